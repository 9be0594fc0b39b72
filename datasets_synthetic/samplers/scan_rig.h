#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include <glm/glm.hpp>

namespace pointreel {

/// A camera or a projector without distortion: the axes of its picture and its direction, which
/// form a right-handed frame (right, up, -forward).
struct Pinhole {
  glm::dvec3 position{0.0};
  glm::dvec3 right{1, 0, 0}, up{0, 1, 0}, forward{0, 0, -1};

  /// The coordinates in the picture plane one metre in front, and the depth along `forward`.
  glm::dvec3 project(const glm::dvec3& p) const {
    const glm::dvec3 d = p - position;
    const double depth = glm::dot(d, forward);
    return {glm::dot(d, right) / depth, glm::dot(d, up) / depth, depth};
  }
  /// The direction of the point (x, y) of the picture plane; its component along `forward` is 1.
  glm::dvec3 toward(double x, double y) const { return forward + x * right + y * up; }
};

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

/// A pinhole at `position` that looks at `target`, with y upwards. It must not look straight up or
/// down.
Pinhole look_at(const glm::dvec3& position, const glm::dvec3& target);

}  // namespace pointreel
