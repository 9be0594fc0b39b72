#include "codec/core/scalar_fields.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "common/base/concat.h"

namespace pointreel {

ScalarSummary summary_of(std::span<const float> values) {
  ScalarSummary summary;
  summary.whole = true;
  for (const float value : values) {
    if (!std::isfinite(value)) continue;
    summary.least = summary.known == 0 ? value : std::min(summary.least, double{value});
    summary.most = summary.known == 0 ? value : std::max(summary.most, double{value});
    summary.whole = summary.whole && std::floor(value) == value;
    ++summary.known;
  }
  summary.whole = summary.whole && summary.known > 0;
  constexpr double kMostSpan = 255.0;
  if (!summary.whole || summary.range() > kMostSpan) return summary;
  std::array<bool, static_cast<std::size_t>(kMostSpan) + 1> seen{};
  for (const float value : values) {
    if (std::isfinite(value)) seen[static_cast<std::size_t>(value - summary.least)] = true;
  }
  summary.distinct = static_cast<std::size_t>(std::ranges::count(seen, true));
  return summary;
}

std::vector<ScalarRange> ranges_of(const PointCloud& cloud) {
  std::vector<ScalarRange> ranges;
  for (const ScalarField& field : cloud.scalars) {
    const ScalarSummary summary = summary_of(field.values);
    if (summary.known > 0)
      ranges.push_back({field.name, summary.least, summary.most, summary.labels()});
  }
  return ranges;
}

void cover(std::vector<ScalarRange>& all, const std::vector<ScalarRange>& more) {
  for (const ScalarRange& range : more) {
    const auto known =
        std::ranges::find_if(all, [&](const ScalarRange& r) { return r.name == range.name; });
    if (known == all.end()) {
      if (all.size() < kMaxScalars) all.push_back(range);
      continue;
    }
    known->least = std::min(known->least, range.least);
    known->most = std::max(known->most, range.most);
    known->labels = known->labels && range.labels;
  }
}

void add_scalar_layer(std::vector<std::string>& layer_names) {
  constexpr const char* kName = "scalars";
  if (std::ranges::find(layer_names, kName) == layer_names.end()) layer_names.push_back(kName);
}

Result<void> check_scalars(const PointCloud& cloud) {
  const auto refused = [](std::string message) {
    return fail(ErrorCode::argument, std::move(message));
  };
  const std::vector<ScalarField>& fields = cloud.scalars;
  if (fields.size() > kMaxScalars) {
    return refused(concat("a cloud has ", fields.size(), " scalar fields, but may have ",
                          kMaxScalars, ": leave some out"));
  }
  for (std::size_t i = 0; i < fields.size(); ++i) {
    if (!is_scalar_name(fields[i].name)) {
      return refused(concat("the name of scalar field ", i, " is not 1 to ", kMaxScalarName,
                            " bytes of printable UTF-8"));
    }
    if (fields[i].values.size() != cloud.size()) {
      return refused(concat("scalar field ", fields[i].name, " has ", fields[i].values.size(),
                            " values for ", cloud.size(), " points"));
    }
    for (std::size_t j = 0; j < i; ++j) {
      if (fields[j].name == fields[i].name)
        return refused(concat("two scalar fields have the name ", fields[i].name));
    }
  }
  return {};
}

}  // namespace pointreel
