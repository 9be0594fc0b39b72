#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include <glm/glm.hpp>

#include "client/scene/camera.h"

namespace pointreel {

/// What a camera sees, without a far end, in coordinates that count from `origin` in units of
/// `unit`: those of a cloud, or the edge of an octree's cube.
class Frustum {
 public:
  enum class Side { outside, crossing, inside };

  Frustum(const Camera& camera, glm::ivec2 size, const glm::dvec3& origin, double unit) {
    const glm::dmat3 axes = camera.axes();
    const double scale = 1.0 / unit;
    const glm::dvec3 eye = (camera.eye() - origin) * scale;
    const double ty = std::tan(0.5 * camera.fov_y), tx = ty * size.x / size.y;
    forward_ = plane(-axes[2], eye);
    sides_ = {plane(glm::normalize(axes[0] - tx * axes[2]), eye),
              plane(glm::normalize(-axes[0] - tx * axes[2]), eye),
              plane(glm::normalize(axes[1] - ty * axes[2]), eye),
              plane(glm::normalize(-axes[1] - ty * axes[2]), eye)};
    slope_ = glm::vec2(static_cast<float>(tx), static_cast<float>(ty));
    eye_ = glm::vec3(eye);
    near_ = static_cast<float>(camera.near_plane() * scale);
    slack_ = static_cast<float>(1e-6 * (1.0 + glm::length(eye)));
  }

  const glm::vec3& eye() const { return eye_; }
  float near() const { return near_; }
  /// Half the width and half the height of the view, at depth 1.
  const glm::vec2& slope() const { return slope_; }
  /// Enough for a few roundings of numbers as large as the eye's distance.
  float slack() const { return slack_; }
  /// The distance from the eye along the view's axis.
  float depth(const glm::vec3& p) const { return forward_.distance(p); }

  /// Where a sphere is. "crossing" may be said of one that is just outside or inside.
  Side classify(const glm::vec3& center, float radius) const {
    const float r = radius + slack_;
    float least = forward_.distance(center) - near_;
    for (const Plane& side : sides_) least = std::min(least, side.distance(center));
    return least < -r ? Side::outside : least > r ? Side::inside : Side::crossing;
  }

 private:
  struct Plane {
    glm::vec3 normal;
    float offset;
    float distance(const glm::vec3& p) const { return glm::dot(normal, p) + offset; }
  };

  static Plane plane(const glm::dvec3& normal, const glm::dvec3& eye) {
    return {glm::vec3(normal), static_cast<float>(-glm::dot(normal, eye))};
  }

  Plane forward_{};
  std::array<Plane, 4> sides_{};
  glm::vec3 eye_{};
  glm::vec2 slope_{};
  float near_ = 0.0f, slack_ = 0.0f;
};

}  // namespace pointreel
