#pragma once

#include <glm/glm.hpp>

#include "client/render/region.h"
#include "client/scene/camera.h"
#include "client/scene/draw_options.h"
#include "client/scene/floor_grid.h"

namespace pointreel {

/// How a camera sees a scene in a picture, with coordinates relative to an origin near the scene.
/// The layout is that of the View block of common.glsl.
struct PictureView {
  glm::mat4 to_clip;  ///< from the scene to clip coordinates, with reversed depth; w is the depth
  glm::vec4 eye;      ///< xyz: position in the scene; w: distance of the near plane
  glm::vec4 light;    ///< xyz: unit vector towards the light; w: light_strength, or kShowNormals to
                      ///< draw 0.5 + 0.5 n in place of colours
  glm::vec4 pixel;    ///< x: size of a pixel at depth 1; y: 1 if the signs of normals are unknown
  /// The ray from the eye through window coordinates (x, y), counted from the lower left corner, is
  /// ray_corner + x ray_x + y ray_y (xyz). It reaches depth 1.
  glm::vec4 ray_corner, ray_x, ray_y;
  glm::vec4 window;  ///< xy: size of the picture in pixels
};

/// For `light.w`: sums of this find the normals of pixels (opengl/late_light.h).
inline constexpr float kShowNormals = 2.0f;

/// How much of the colours the light takes where it does not shine: 0 without lighting. Colours
/// that a camera recorded have light in them already, and need little to show shape.
inline float light_strength(bool lighting, bool colored) {
  return lighting ? (colored ? 0.3f : 1.0f) : 0.0f;
}

PictureView make_view(const Camera& camera, const glm::dvec3& origin, glm::ivec2 size, float light,
                      bool signs_unknown);

/// The factors by which the two passes of splatting multiply radii. `chosen` are those for
/// Splatting::normalized. FORMULAS.md, "Splat scales".
SplatScales scales_of(Splatting splatting, const SplatScales& chosen);

/// The part of a picture in which elements within `bounds` may be visible.
PixelRect elements_region(const DrawOptions& options, const InstanceBounds& bounds,
                          const glm::mat4& to_clip, glm::ivec2 size);

/// Whether the eye is on the upper side of a floor.
bool is_above(const glm::dvec3& eye, const FloorGrid& grid);

/// The light of a floor's lines, white or black, and their opacity where they are strongest, which
/// show on this background (sRGB).
struct FloorInk {
  float light, opacity;
};
FloorInk floor_ink(const glm::vec3& background);

}  // namespace pointreel
