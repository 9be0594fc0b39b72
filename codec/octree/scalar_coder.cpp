#include "codec/octree/scalar_coder.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "codec/core/scalar_fields.h"
#include "codec/octree/attribute_coder.h"
#include "codec/octree/attribute_value.h"
#include "common/base/byte_io.h"
#include "common/base/concat.h"
#include "common/base/for_each.h"
#include "common/base/try.h"

namespace pointreel {
namespace {

/// Values are multiples 0 to kMostMultiple of a step. The transform holds no more.
constexpr std::int32_t kMostMultiple = kMostValue - kLeastValue;
static_assert(kMostMultiple == kMostScalarSteps);

enum FieldFlags : std::uint8_t { kLabels = 1, kUnknown = 2 };

/// The offset and the step of a field.
struct ScalarScale {
  double offset = 0.0, step = 1.0;

  /// The number that stands for a known value.
  std::int32_t multiple(float value) const {
    return static_cast<std::int32_t>(
        std::clamp(std::floor((value - offset) / step + 0.5), 0.0, double{kMostMultiple}));
  }
};

/// The width of the interval that holds all values but a few far out, which shall not make the step
/// of all others coarse: one in 1000 on either side.
double usual_width(const ScalarField& field, const ScalarSummary& summary) {
  const ScalarScale finest{summary.least, summary.range() / kMostMultiple};
  std::vector<std::uint32_t> counts(static_cast<std::size_t>(kMostMultiple) + 1);
  for (const float value : field.values) {
    if (!std::isnan(value)) ++counts[static_cast<std::size_t>(finest.multiple(value))];
  }
  const std::size_t few = summary.known / 1000;
  const auto skip = [few](auto at) {
    for (std::size_t sum = *at; sum <= few;) sum += *++at;
    return at;
  };
  const auto first = skip(counts.begin());
  const auto last = skip(counts.rbegin()).base();  // behind the last one
  return static_cast<double>(last - first - 1) * finest.step;
}

ScalarScale scale_of(const ScalarField& field, const ScalarSummary& summary,
                     std::span<const ScalarStep> steps) {
  const double least_step = summary.range() / kMostMultiple;
  const auto stated =
      std::ranges::find_if(steps, [&](const ScalarStep& step) { return step.name == field.name; });
  if (stated != steps.end()) {
    // From a multiple of the step on, so that other multiples come back exactly.
    const double step = std::max(stated->step, least_step);
    const double offset = std::floor(summary.least / step) * step;
    if ((summary.most - offset) / step <= kMostMultiple) return {offset, step};
    return {summary.least, step};
  }
  constexpr double kSteps = 255.0;
  if (summary.range() == 0.0 || (summary.whole && summary.range() <= kSteps))
    return {summary.least, 1.0};
  return {summary.least, std::max(usual_width(field, summary) / kSteps, least_step)};
}

/// The number that most of them are; of those that are equally frequent, the least.
std::int32_t most_frequent(std::vector<std::int32_t>& numbers) {
  std::sort(numbers.begin(), numbers.end());
  std::int32_t best = numbers.front();
  std::ptrdiff_t most = 0;
  for (auto begin = numbers.begin(); begin != numbers.end();) {
    const auto end = std::upper_bound(begin, numbers.end(), *begin);
    if (end - begin > most) {
      most = end - begin;
      best = *begin;
    }
    begin = end;
  }
  return best;
}

std::int32_t rounded_mean(const std::vector<std::int32_t>& numbers) {
  std::int64_t sum = 0;
  for (const std::int32_t number : numbers) sum += number;
  const auto count = static_cast<std::int64_t>(numbers.size());
  return static_cast<std::int32_t>((2 * sum + count) / (2 * count));
}

Short4 leaf_value(std::int32_t multiple, bool unknown) {
  return stored_value(Int4{multiple + kLeastValue, unknown ? 1 : 0, 0, 0} + fourth_lane(0));
}

/// The values of the leaves, and whether any is unknown. Leaves without a known value have that of
/// the leaf before, which costs least.
std::vector<Short4> leaf_values(const Svo& svo, const SortedPoints& sorted,
                                const ScalarField& field, const ScalarScale& scale, bool labels,
                                bool& any_unknown) {
  const int shift = 3 * (sorted.levels - svo.depth);
  std::vector<Short4> leaves(svo.leaf_count());
  std::vector<std::int32_t> numbers;
  std::int32_t last = 0;
  auto point = sorted.points.begin();
  for (Short4& leaf : leaves) {
    numbers.clear();
    const std::uint64_t key = point->key >> shift;
    for (; point != sorted.points.end() && point->key >> shift == key; ++point) {
      const float value = field.values[point->index];
      if (!std::isnan(value)) numbers.push_back(scale.multiple(value));
    }
    if (!numbers.empty()) last = labels ? most_frequent(numbers) : rounded_mean(numbers);
    any_unknown = any_unknown || numbers.empty();
    leaf = leaf_value(last, numbers.empty());
  }
  return leaves;
}

/// A field's entry in the directory, and its streams.
struct EncodedField {
  Bytes entry, streams;
};

EncodedField encode_field(const FrameStructure& structure, const SortedPoints& sorted,
                          const ScalarField& field, const ScalarSummary& summary,
                          std::span<const ScalarStep> steps) {
  const ScalarScale scale = scale_of(field, summary, steps);
  const bool labels = summary.labels() && scale.step == 1.0;
  bool any_unknown = false;
  const std::vector<Short4> leaves =
      leaf_values(structure.svo(), sorted, field, scale, labels, any_unknown);
  TransformEncoder encoder(structure, AttributeKind::colors, leaves, true);
  EncodedField encoded;
  ByteWriter entry(encoded.entry);
  entry.put(static_cast<std::uint8_t>((labels ? kLabels : 0) | (any_unknown ? kUnknown : 0)));
  entry.put(scale.offset);
  entry.put(scale.step);
  entry.put(static_cast<std::uint8_t>(field.name.size()));
  for (const char c : field.name) entry.put(static_cast<std::uint8_t>(c));
  for (std::size_t layer = 0; layer < structure.layer_ends().size(); ++layer) {
    const Bytes stream = encoder.encode_layer(kExactSteps);
    entry.put(static_cast<std::uint32_t>(stream.size()));
    encoded.streams.insert(encoded.streams.end(), stream.begin(), stream.end());
  }
  return encoded;
}

/// Reads one entry of the directory. The sizes of the streams are appended to `sizes`.
Result<ScalarStreams> parse_entry(ByteReader& reader, std::size_t layers,
                                  std::vector<std::uint32_t>& sizes) {
  ScalarStreams field;
  const auto flags = reader.get<std::uint8_t>();
  field.offset = reader.get<double>();
  field.step = reader.get<double>();
  const std::size_t length = reader.get<std::uint8_t>();
  for (std::size_t i = 0; i < length; ++i)
    field.name.push_back(static_cast<char>(reader.get<std::uint8_t>()));
  for (std::size_t layer = 0; layer < layers; ++layer) sizes.push_back(reader.get<std::uint32_t>());
  if (!reader.ok()) return fail("the fields are cut short");
  if (flags > (kLabels | kUnknown) || !std::isfinite(field.offset) || !(field.step > 0.0) ||
      !std::isfinite(field.step) || !is_scalar_name(field.name)) {
    return fail("a field is out of range");
  }
  field.labels = (flags & kLabels) != 0;
  field.unknown = (flags & kUnknown) != 0;
  return field;
}

}  // namespace

Bytes encode_scalars(const FrameStructure& structure, const PointCloud& cloud,
                     const SortedPoints& sorted, std::span<const ScalarStep> steps,
                     const Executor& executor) {
  std::vector<std::pair<const ScalarField*, ScalarSummary>> fields;
  for (const ScalarField& field : cloud.scalars) {
    const ScalarSummary summary = summary_of(field.values);
    if (summary.known > 0) fields.emplace_back(&field, summary);
  }
  if (fields.empty()) return {};
  std::vector<EncodedField> encoded(fields.size());
  for_each(executor, static_cast<int>(fields.size()), [&](int i) {
    const auto& [field, summary] = fields[static_cast<std::size_t>(i)];
    encoded[static_cast<std::size_t>(i)] = encode_field(structure, sorted, *field, summary, steps);
  });
  Bytes payload = {static_cast<std::uint8_t>(fields.size())};
  for (const EncodedField& field : encoded)
    payload.insert(payload.end(), field.entry.begin(), field.entry.end());
  for (const EncodedField& field : encoded)
    payload.insert(payload.end(), field.streams.begin(), field.streams.end());
  return payload;
}

Result<std::vector<ScalarStreams>> parse_scalars(ByteView payload, std::size_t layers) {
  ByteReader reader(payload);
  const auto count = reader.get<std::uint8_t>();
  if (count < 1 || count > kMaxScalars)
    return fail(concat("there are ", count, " fields, not 1 to ", kMaxScalars));
  std::vector<ScalarStreams> fields;
  std::vector<std::uint32_t> sizes;
  for (int i = 0; i < count; ++i) {
    ScalarStreams field = TRY(parse_entry(reader, layers, sizes));
    if (std::ranges::any_of(fields, [&](const auto& other) { return other.name == field.name; }))
      return fail("two fields have the same name");
    fields.push_back(std::move(field));
  }
  ByteView rest = reader.rest();
  auto size = sizes.begin();
  for (ScalarStreams& field : fields) {
    for (std::size_t layer = 0; layer < layers; ++layer, ++size) {
      if (*size > rest.size()) return fail("the streams are cut short");
      field.layers.push_back(rest.first(*size));
      rest = rest.subspan(*size);
    }
  }
  if (!rest.empty()) return fail("bytes follow the streams");
  return fields;
}

Result<ScalarField> decode_scalar(const FrameStructure& structure, const ScalarStreams& streams) {
  TransformDecoder decoder(structure, AttributeKind::colors);
  for (std::size_t layer = 0; layer < streams.layers.size(); ++layer) {
    TRY(decoder.decode_layer(streams.layers[layer], structure.layer_ends()[layer]));
    if (!decoder.exact()) return fail("a field is out of range");
  }
  constexpr double kMost = std::numeric_limits<float>::max();
  const std::span<const Short4> values = decoder.values(structure.svo().depth);
  ScalarField field{streams.name, std::vector<float>(values.size())};
  for (std::size_t i = 0; i < values.size(); ++i) {
    const double multiple = values[i].lanes[0] - kLeastValue;
    const bool unknown = streams.unknown && values[i].lanes[1] != 0;
    field.values[i] = unknown ? std::numeric_limits<float>::quiet_NaN()
                              : static_cast<float>(std::clamp(
                                    streams.offset + streams.step * multiple, -kMost, kMost));
  }
  return field;
}

}  // namespace pointreel
