#include "client/render/view.h"

#include <algorithm>
#include <cmath>

#include "client/render/srgb.h"

namespace pointreel {
namespace {

/// The direction to the light in eye space, over the viewer's left shoulder.
const glm::dvec3 kLight = glm::normalize(glm::dvec3(-0.35, 0.45, 1.0));

/// The paper's factor (Slomp et al., Geometry Instancing, Figure 3).
constexpr float kEnlargement = 2.0f;

/// Distance of a cube's corner from its centre, in halves of the edge.
constexpr float kCubeCorner = 1.7321f;

}  // namespace

PictureView make_view(const Camera& camera, const glm::dvec3& origin, glm::ivec2 size, float light,
                      bool signs_unknown) {
  const glm::dmat3 axes = camera.axes();
  const double slope = std::tan(0.5 * camera.fov_y), step = 2.0 * slope / size.y;
  return {camera.projection(static_cast<double>(size.x) / size.y) * camera.view_from(origin),
          glm::vec4(glm::vec3(camera.eye() - origin), static_cast<float>(camera.near_plane())),
          glm::vec4(glm::vec3(axes * kLight), light),
          glm::vec4(static_cast<float>(step), signs_unknown ? 1.0f : 0.0f, 0.0f, 0.0f),
          glm::vec4(glm::vec3(-axes[2] - 0.5 * step * size.x * axes[0] - slope * axes[1]), 0.0f),
          glm::vec4(glm::vec3(step * axes[0]), 0.0f),
          glm::vec4(glm::vec3(step * axes[1]), 0.0f),
          glm::vec4(glm::vec2(size), 0.0f, 0.0f)};
}

SplatScales scales_of(Splatting splatting, const SplatScales& chosen) {
  switch (splatting) {
    case Splatting::enlarged:
      return {kEnlargement, kEnlargement};
    case Splatting::enlarged_shading:
      return {1.0f, kEnlargement};
    case Splatting::normalized:
      return chosen;
    default:
      return {};
  }
}

PixelRect elements_region(const DrawOptions& options, const InstanceBounds& bounds,
                          const glm::mat4& to_clip, glm::ivec2 size) {
  switch (options.mode) {
    case DrawMode::surfel: {
      // Quads are drawn around the discs, and their corners are farther out.
      const SplatScales scales = scales_of(options.splatting, options.scales);
      const float scale = 1.5f * std::max(scales.visibility, scales.shading);
      return region_of(bounds, scale, to_clip, size);
    }
    case DrawMode::strip:  // triangles reach no farther than their corners
      return region_of(bounds, 0.0f, to_clip, size, 1);
    case DrawMode::voxel:  // no voxel is drawn smaller than a pixel
      return region_of(bounds, kCubeCorner, to_clip, size, 1);
    case DrawMode::point:
      return region_of(bounds, options.adaptive_points ? 1.0f : 0.0f, to_clip, size,
                       static_cast<int>(std::ceil(0.5f * options.point_size)));
  }
  return {};
}

bool is_above(const glm::dvec3& eye, const FloorGrid& grid) {
  return glm::dot(eye - floor_origin(grid), grid.up.direction()) >= 0.0;
}

FloorInk floor_ink(const glm::vec3& background) {
  const float luminance = 0.2126f * linear_from_srgb(background.x) +
                          0.7152f * linear_from_srgb(background.y) +
                          0.0722f * linear_from_srgb(background.z);
  // In linear light, a little white is conspicuous on black, but a little black is not on white.
  return luminance < 0.18f ? FloorInk{1.0f, 0.16f} : FloorInk{0.0f, 0.5f};
}

}  // namespace pointreel
