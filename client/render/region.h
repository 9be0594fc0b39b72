#pragma once

#include <glm/glm.hpp>

namespace pointreel {

/// What instances lie in, in their coordinates, and the largest of their radii.
struct InstanceBounds {
  glm::vec3 min{1.0f}, max{-1.0f};  ///< min > max: nothing
  float radius = 0.0f;

  void grow(const glm::vec3& center, float its_radius);
  bool empty() const { return min.x > max.x; }
};

/// Pixels from `min` on, lower left first, to before `max`.
struct PixelRect {
  glm::ivec2 min{0}, max{0};
  bool operator==(const PixelRect&) const = default;
};

/// The part of a picture in which spheres around the instances, `scale` times as large as they,
/// may show; the whole picture where some of the box is not in front of the eye. `to_clip` leads
/// to clip coordinates whose w is the depth.
PixelRect region_of(const InstanceBounds& bounds, float scale, const glm::mat4& to_clip,
                    glm::ivec2 size);

}  // namespace pointreel
