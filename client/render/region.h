#pragma once

#include <cstddef>

#include <glm/glm.hpp>

namespace pointreel {

/// What instances lie in, in their coordinates, and how large they are.
struct InstanceBounds {
  glm::vec3 min{1.0f}, max{-1.0f};  ///< min > max: nothing
  float radius = 0.0f;              ///< the largest
  double all_radii = 0.0;
  std::size_t count = 0;

  void grow(const glm::vec3& center, float its_radius);
  bool empty() const { return min.x > max.x; }
  double mean_radius() const { return count > 0 ? all_radii / static_cast<double>(count) : 0.0; }
};

/// Pixels from `min` on, lower left first, to before `max`.
struct PixelRect {
  glm::ivec2 min{0}, max{0};
  bool empty() const { return min.x >= max.x || min.y >= max.y; }
  bool operator==(const PixelRect&) const = default;
};

/// Holds both.
PixelRect around(const PixelRect& a, const PixelRect& b);

/// The part of a picture in which spheres around the instances, `scale` times as large as they,
/// may show, and `pixels` more on each side; the whole picture where some of the box is not in
/// front of the eye. `to_clip` leads to clip coordinates whose w is the depth.
PixelRect region_of(const InstanceBounds& bounds, float scale, const glm::mat4& to_clip,
                    glm::ivec2 size, int pixels = 0);

/// Of an instance of the mean radius in the middle of them all, in pixels; 0 where that is not in
/// front of the eye.
float radius_in_pixels(const InstanceBounds& bounds, const glm::mat4& to_clip, glm::ivec2 size);

}  // namespace pointreel
