#include "tests/bench/surface/treatments.h"

#include <algorithm>
#include <span>
#include <utility>

#include <fmt/format.h>

#include "tests/bench/measure.h"
#include "tests/bench/surface/smoothing_library.h"
#include "tests/bench/surface/true_surface.h"

namespace pointreel::bench {
namespace {

/// Times of rows whose depth is fixed are not shown.
int runs_of(const Treatment& treatment, int runs) { return treatment.depth ? 1 : runs; }

/// As auto would report it, since the samples are those of auto.
CleanReport as_cleaned(const CleanReport& automatic) {
  CleanReport report;
  report.cleaned = true;
  report.cell = automatic.cell;
  return report;
}

CleanReport clean_with_others(PointCloud& cloud, std::span<const CleanedFrame> around) {
  CleanedFrame alone = clean_alone(std::move(cloud), {});
  std::vector<const CleanedFrame*> others;
  for (const CleanedFrame& other : around) others.push_back(&other);
  auto in_time = clean_in_time(alone, others, {});
  cloud = in_time ? std::move(in_time->cloud) : std::move(alone.cloud);
  return in_time ? in_time->report : alone.report;
}

CleanReport apply(PointCloud& cloud, std::span<const CleanedFrame> around, const Body& truth,
                  const Treatment& treatment, const CleanReport& automatic) {
  switch (treatment.kind) {
    case Treatment::Kind::off:
    case Treatment::Kind::settled:
      return {};
    case Treatment::Kind::automatic:
      return clean(cloud);
    case Treatment::Kind::in_time:
      return clean_with_others(
          cloud,
          around.first(std::min(around.size(), 2 * static_cast<std::size_t>(treatment.value))));
    case Treatment::Kind::radius:
      return clean(cloud, {.radius = treatment.value});
    case Treatment::Kind::beta:
      return clean(cloud, {.beta = treatment.value});
    case Treatment::Kind::truth:
      cloud = onto_true_surface(truth, cloud);
      return as_cleaned(automatic);
    case Treatment::Kind::library:
      break;
  }
  for (int pass = 0; pass < static_cast<int>(treatment.value); ++pass) smooth_bilaterally(cloud);
  return as_cleaned(automatic);
}

}  // namespace

std::string name(Treatment::Kind kind) {
  switch (kind) {
    case Treatment::Kind::off:
      return "off";
    case Treatment::Kind::automatic:
      return "auto";
    case Treatment::Kind::in_time:
      return "in time";
    case Treatment::Kind::settled:
      return "off, settled";
    case Treatment::Kind::truth:
      return "truth";
    case Treatment::Kind::radius:
      return "radius";
    case Treatment::Kind::beta:
      return "beta";
    case Treatment::Kind::library:
      break;
  }
  return "library";
}

std::string name(const Treatment& treatment) {
  std::string out = name(treatment.kind);
  if (treatment.kind == Treatment::Kind::in_time) {
    out = fmt::format("auto, {:g} frames", 1.0 + 2.0 * treatment.value);
  } else if (treatment.kind == Treatment::Kind::radius) {
    out += fmt::format(" {:g} mm", 1000.0 * treatment.value);
  } else if (treatment.kind == Treatment::Kind::beta) {
    out += fmt::format(" {:g}", treatment.value);
  } else if (treatment.kind == Treatment::Kind::library) {
    out = fmt::format("CGAL bilateral, {:g}x", treatment.value);
  }
  if (treatment.depth) out += fmt::format(", depth {}", *treatment.depth);
  return out;
}

std::vector<Treatment> surface_treatments(bool quick) {
  using enum Treatment::Kind;
  const auto list = [&](std::vector<double> all, std::vector<double> few) {
    return quick ? few : all;
  };
  std::vector<Treatment> treatments = {
      {.kind = off}, {.kind = automatic}, {.kind = settled}, {.kind = truth}};
  for (const double frames : list({1, 2}, {2}))
    treatments.push_back({.kind = in_time, .value = frames});
  for (const double millimetres : list({6, 10, 16, 25, 40, 64, 100}, {10, 40})) {
    treatments.push_back({.kind = radius, .value = millimetres / 1000.0});
  }
  for (const double beta : {0.0, 0.25, 0.75, 1.0}) {
    treatments.push_back({.kind = Treatment::Kind::beta, .value = beta});
  }
  const std::vector<double> passes =
      smoothing_library() ? list({1, 2, 4}, {2}) : std::vector<double>{};
  for (const double count : passes) {
    treatments.push_back({.kind = library, .value = count});
  }
  std::vector<Treatment> by_depth = {{.kind = off}, {.kind = automatic}};
  if (!passes.empty()) by_depth.push_back({.kind = library, .value = passes.back()});
  for (Treatment treatment : by_depth) {
    for (const double depth : list({7, 8, 9, 10}, {8, 9})) {
      treatment.depth = static_cast<int>(depth);
      treatment.pictures = false;
      treatments.push_back(treatment);
    }
  }
  return treatments;
}

Treated treat(const FrameInTime& frame, const Body& truth, const Treatment& treatment,
              const CleanReport& automatic, int runs) {
  Treated treated;
  std::vector<double> times;
  for (int run = 0; run < runs_of(treatment, runs); ++run) {
    treated.cloud = frame.cloud;
    const double begin = now_ms();
    treated.report = apply(treated.cloud, frame.around, truth, treatment, automatic);
    times.push_back(now_ms() - begin);
  }
  if (treatment.kind != Treatment::Kind::off && treatment.kind != Treatment::Kind::settled) {
    treated.milliseconds = summarise(std::move(times)).median;
  }
  return treated;
}

}  // namespace pointreel::bench
