#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/surface/clean.h"
#include "pointreel/cloud.h"

namespace pointreel::bench {

/// What is done to a frame before it is encoded.
struct Treatment {
  enum class Kind { off, automatic, radius, beta, library };
  Kind kind = Kind::off;
  double value = 0.0;  ///< the radius in metres, beta, or the number of passes
  /// The octree's levels. Absent: as pack chooses them.
  std::optional<int> depth = std::nullopt;
  bool pictures = true;  ///< whether pictures of the frame are measured
};

/// For people: "off", "radius 12 mm", "auto, depth 9".
std::string name(const Treatment& treatment);
/// "off", "auto", "radius", "beta", "library".
std::string name(Treatment::Kind kind);

/// Off and auto first. Those of the library only if this program has it.
std::vector<Treatment> surface_treatments(bool quick);

/// What was done, and how long it took on one thread.
struct Treated {
  CleanReport report;
  double milliseconds = 0.0;
};
/// Treats the cloud `runs` times and keeps one result. The report of the library's smoothing has
/// the `cell` of `automatic`, the report of auto: samples that far apart are told apart.
Treated treat(PointCloud& cloud, const Treatment& treatment, const CleanReport& automatic,
              int runs);

}  // namespace pointreel::bench
