#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "datasets_synthetic/samplers/pinhole.h"

namespace pointreel {

/// A ring of cameras and projectors around the scene, alternating and equally many (R. Furukawa et
/// al., "One-shot Entire Shape Acquisition Method Using Multiple Projectors and Cameras", PSIVT
/// 2010). They look at a point above the origin, alternately from a high and from a low place.
/// Lengths are in metres.
struct RigOptions {
  int projectors = 4;       ///< >= 2; there are as many cameras
  double radius = 3.0;      ///< of the ring
  double low = 0.6;         ///< height of every second camera and projector
  double high = 2.3;        ///< height of the others
  double target = 0.9;      ///< height of the point that they look at
  double half_field = 0.8;  ///< tangent of half the field of view, horizontally and vertically
};

struct Rig {
  /// A camera and the projector whose pattern it observes.
  struct Pair {
    std::size_t projector, camera;
  };
  std::vector<Pinhole> projectors, cameras;
  std::vector<Pair> pairs;  ///< every projector with its left and its right neighbouring camera
};

/// The mean distance in metres between the devices and the point that they look at.
double working_distance(const RigOptions& options);

/// The rig with these options. It is the same on every machine.
Rig make_rig(const RigOptions& options);

}  // namespace pointreel
