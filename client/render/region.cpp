#include "client/render/region.h"

#include <cmath>

namespace pointreel {

void InstanceBounds::grow(const glm::vec3& center, float its_radius) {
  if (empty()) {
    min = max = center;
  } else {
    min = glm::min(min, center);
    max = glm::max(max, center);
  }
  radius = glm::max(radius, its_radius);
  all_radii += its_radius;
  ++count;
}

void InstanceBounds::grow(const InstanceBounds& other) {
  if (other.empty()) return;
  if (empty()) {
    min = other.min;
    max = other.max;
  } else {
    min = glm::min(min, other.min);
    max = glm::max(max, other.max);
  }
  radius = glm::max(radius, other.radius);
  all_radii += other.all_radii;
  count += other.count;
}

PixelRect around(const PixelRect& a, const PixelRect& b) {
  if (a.empty()) return b;
  if (b.empty()) return a;
  return {glm::min(a.min, b.min), glm::max(a.max, b.max)};
}

PixelRect region_of(const InstanceBounds& bounds, float scale, const glm::mat4& to_clip,
                    glm::ivec2 size, int pixels) {
  if (bounds.empty()) return {};
  const glm::vec3 low = bounds.min - scale * bounds.radius,
                  high = bounds.max + scale * bounds.radius;
  const PixelRect whole{glm::ivec2(0), size};
  glm::vec2 least(1.0f), most(-1.0f);  // normalised device coordinates
  for (int corner = 0; corner < 8; ++corner) {
    const glm::vec4 clip =
        to_clip * glm::vec4(corner & 1 ? high.x : low.x, corner & 2 ? high.y : low.y,
                            corner & 4 ? high.z : low.z, 1.0f);
    // The comparison is negated so that a NaN gives the whole picture.
    if (!(clip.w > 1e-6f * (glm::length(high - low) + bounds.radius))) return whole;
    least = glm::min(least, glm::vec2(clip) / clip.w);
    most = glm::max(most, glm::vec2(clip) / clip.w);
  }
  // One pixel more, because no sprite is smaller than a pixel.
  const float more = static_cast<float>(pixels) + 1.0f;
  const glm::vec2 half = 0.5f * glm::vec2(size);
  const glm::vec2 from = glm::floor((glm::max(least, -1.0f) + 1.0f) * half) - more;
  const glm::vec2 to = glm::ceil((glm::min(most, 1.0f) + 1.0f) * half) + more;
  const PixelRect region{glm::clamp(glm::ivec2(from), glm::ivec2(0), size),
                         glm::clamp(glm::ivec2(to), glm::ivec2(0), size)};
  return glm::any(glm::lessThan(region.max, region.min)) ? PixelRect{} : region;
}

float nearest_depth(const InstanceBounds& bounds, const glm::mat4& to_clip, float near) {
  // The depth is linear, so each coordinate alone decides for one side of the box.
  const glm::vec3 slope(to_clip[0].w, to_clip[1].w, to_clip[2].w);
  const glm::vec3 corner = glm::mix(bounds.min, bounds.max, glm::lessThan(slope, glm::vec3(0.0f)));
  return glm::max(glm::dot(slope, corner) + to_clip[3].w, near);
}

float radius_in_pixels(const InstanceBounds& bounds, const glm::mat4& to_clip, glm::ivec2 size) {
  const glm::vec4 middle = to_clip * glm::vec4(0.5f * (bounds.min + bounds.max), 1.0f);
  if (bounds.empty() || !(middle.w > 0.0f)) return 0.0f;
  const float up = glm::length(glm::vec3(to_clip[0].y, to_clip[1].y, to_clip[2].y));
  return 0.5f * static_cast<float>(size.y) * up * static_cast<float>(bounds.mean_radius()) /
         middle.w;
}

}  // namespace pointreel
