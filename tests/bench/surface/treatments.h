#pragma once

#include <optional>
#include <string>
#include <vector>

#include "codec/surface/clean_in_time.h"
#include "datasets_synthetic/body.h"
#include "pointreel/cloud.h"

namespace pointreel::bench {

/// What is done to a frame before it is encoded.
struct Treatment {
  /// `in_time` is auto with `value` frames on either side. `settled` is off, too, and `truth` puts
  /// each point onto the nearest place of the true surface, with its normal and colour: what no
  /// cleaning can do better.
  enum class Kind { off, automatic, in_time, settled, radius, beta, library, truth };
  Kind kind = Kind::off;
  double value = 0.0;  ///< the radius in metres, beta, or the number of frames or passes
  /// The octree's levels. Absent: as pack chooses them.
  std::optional<int> depth = std::nullopt;
  bool pictures = true;  ///< whether pictures of the frame are measured
};

/// For people: "off", "radius 12 mm", "auto, depth 9".
std::string name(const Treatment& treatment);
/// "off", "auto", "in time", "off, settled", "radius", "beta", "library", "truth".
std::string name(Treatment::Kind kind);

/// Off and auto first. Those of the library only if this program has it.
std::vector<Treatment> surface_treatments(bool quick);

/// Those in which a still scene shows what the others would show, too, are left out.
inline bool measures_movement(const Treatment& treatment) {
  return treatment.kind != Treatment::Kind::radius && treatment.kind != Treatment::Kind::beta &&
         treatment.kind != Treatment::Kind::truth && !treatment.depth;
}

/// What was done, and how long it took on one thread.
struct Treated {
  PointCloud cloud;
  CleanReport report;
  double milliseconds = 0.0;
};
/// Whether surfels are drawn on the surface, as the player draws them, or in the middle of their
/// cells, as without any of this.
inline bool settles(const Treatment& treatment) { return treatment.kind != Treatment::Kind::off; }

/// A frame, and those around it in time, which were cleaned alone: the nearest first.
struct FrameInTime {
  PointCloud cloud;
  std::vector<CleanedFrame> around;
};

/// Treats the cloud `runs` times and keeps one result. The report of the library's smoothing has
/// the `cell` of `automatic`, the report of auto: samples that far apart are told apart. Of frames
/// in time, the time is that of one of many: it is cleaned alone, and with those around it.
Treated treat(const FrameInTime& frame, const Body& truth, const Treatment& treatment,
              const CleanReport& automatic, int runs);

}  // namespace pointreel::bench
