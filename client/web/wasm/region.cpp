#include "client/web/wasm/region.h"

#include <cstring>

using namespace pointreel;

InstanceBounds pointreel::bounds_of(const PrBounds& from) {
  InstanceBounds bounds;
  bounds.min = {from.min[0], from.min[1], from.min[2]};
  bounds.max = {from.max[0], from.max[1], from.max[2]};
  bounds.radius = static_cast<float>(from.radius);
  bounds.all_radii = from.all_radii;
  bounds.count = static_cast<std::size_t>(from.count);
  return bounds;
}

namespace {

glm::mat4 matrix_of(const float* from) {
  glm::mat4 matrix;
  std::memcpy(&matrix[0][0], from, sizeof(matrix));
  return matrix;
}

}  // namespace

const std::int32_t* pr_region(const PrBounds* bounds, double scale, const float* to_clip,
                              std::int32_t width, std::int32_t height, std::int32_t pixels) {
  static std::int32_t corners[4];
  const PixelRect region = region_of(bounds_of(*bounds), static_cast<float>(scale),
                                     matrix_of(to_clip), {width, height}, pixels);
  corners[0] = region.min.x;
  corners[1] = region.min.y;
  corners[2] = region.max.x;
  corners[3] = region.max.y;
  return corners;
}

double pr_nearest_depth(const PrBounds* bounds, const float* to_clip, double near) {
  return nearest_depth(bounds_of(*bounds), matrix_of(to_clip), static_cast<float>(near));
}

double pr_radius_in_pixels(const PrBounds* bounds, const float* to_clip, std::int32_t width,
                           std::int32_t height) {
  return radius_in_pixels(bounds_of(*bounds), matrix_of(to_clip), {width, height});
}
