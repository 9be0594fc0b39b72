#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include <glm/glm.hpp>

namespace pointreel {

/// A camera or a projector without distortion: the axes of its picture and the way that it looks,
/// a right-handed frame (right, up, -forward).
struct Pinhole {
  glm::dvec3 position{0.0};
  glm::dvec3 right{1, 0, 0}, up{0, 1, 0}, forward{0, 0, -1};

  /// Coordinates in the picture plane a metre in front, and the depth along `forward`.
  glm::dvec3 project(const glm::dvec3& p) const {
    const glm::dvec3 d = p - position;
    const double depth = glm::dot(d, forward);
    return {glm::dot(d, right) / depth, glm::dot(d, up) / depth, depth};
  }
  /// Towards the point (x, y) of the picture plane: of length 1 along `forward`.
  glm::dvec3 toward(double x, double y) const { return forward + x * right + y * up; }
};

/// Cameras and projectors in turn on a ring around the scene, as many of one as of the other (R.
/// Furukawa et al., "One-shot Entire Shape Acquisition Method Using Multiple Projectors and
/// Cameras", PSIVT 2010). They look at a point above the origin, alternately from high and low.
struct RigOptions {
  int projectors = 4;       ///< and as many cameras; >= 2
  double radius = 3.0;      ///< of the ring, metres
  double low = 0.6;         ///< height of every second device of a kind, metres
  double high = 2.3;        ///< and of the others
  double target = 0.9;      ///< height of what they look at, metres
  double half_field = 0.8;  ///< tangent of half the angle that each sees or lights, both ways
};

struct Rig {
  /// A camera that looks for the pattern of one projector.
  struct Pair {
    std::size_t projector, camera;
  };
  std::vector<Pinhole> projectors, cameras;
  std::vector<Pair> pairs;  ///< every projector with the cameras left and right of it
};

/// The distance at which the devices see what they look at: the mean over them, metres.
double working_distance(const RigOptions& options);

/// The same on every machine.
Rig make_rig(const RigOptions& options);

/// Pinhole at `position` that looks at `target` and has y upwards; not straight up or down.
Pinhole look_at(const glm::dvec3& position, const glm::dvec3& target);

}  // namespace pointreel
