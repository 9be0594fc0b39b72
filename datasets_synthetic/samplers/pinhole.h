#pragma once

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

/// A pinhole at `position` that looks at `target`, with y upwards. It must not look straight up or
/// down.
Pinhole look_at(const glm::dvec3& position, const glm::dvec3& target);

}  // namespace pointreel
