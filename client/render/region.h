#pragma once

#include <cstddef>

#include <glm/glm.hpp>

namespace pointreel {

/// The box around the centres of instances, in their coordinates, and their radii.
struct InstanceBounds {
  glm::vec3 min{1.0f}, max{-1.0f};  ///< min > max: no instances
  float radius = 0.0f;              ///< the largest radius
  double all_radii = 0.0;
  std::size_t count = 0;

  void grow(const glm::vec3& center, float its_radius);
  void grow(const InstanceBounds& other);
  bool empty() const { return min.x > max.x; }
  double mean_radius() const { return count > 0 ? all_radii / static_cast<double>(count) : 0.0; }
};

/// The pixels from `min` (included) to `max` (excluded), counted from the lower left corner.
struct PixelRect {
  glm::ivec2 min{0}, max{0};
  bool empty() const { return min.x >= max.x || min.y >= max.y; }
  bool operator==(const PixelRect&) const = default;
};

/// The smallest rectangle that contains both.
PixelRect around(const PixelRect& a, const PixelRect& b);

/// The part of a picture in which the instances may be visible, if their radii are multiplied by
/// `scale`, extended by `pixels` on each side. It is the whole picture if part of the box is not in
/// front of the eye. `to_clip` maps to clip coordinates whose w is the depth.
PixelRect region_of(const InstanceBounds& bounds, float scale, const glm::mat4& to_clip,
                    glm::ivec2 size, int pixels = 0);

/// The smallest depth within the box, and at least `near`.
float nearest_depth(const InstanceBounds& bounds, const glm::mat4& to_clip, float near);

/// The radius in pixels of an instance of the mean radius in the middle of the box. 0 if the middle
/// is not in front of the eye.
float radius_in_pixels(const InstanceBounds& bounds, const glm::mat4& to_clip, glm::ivec2 size);

}  // namespace pointreel
