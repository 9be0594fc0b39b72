#pragma once

#include <memory>
#include <optional>

#include <glm/glm.hpp>

#include "client/scene/draw_mode.h"
#include "client/scene/environment_map.h"
#include "client/scene/floor_grid.h"
#include "common/base/enum_names.h"

namespace pointreel {

/// How instances become triangles. The first four methods are those that Slomp et al., Geometry
/// Instancing, section IV compares.
enum class Instancing {
  geometry,   ///< a geometry shader expands points
  uniform,    ///< hardware instancing; instances in uniform buffers, 64 KiB per draw call
  texture,    ///< hardware instancing; instances in a texture buffer
  attribute,  ///< hardware instancing; instances as vertex attributes ("regular vertex buffers")
  pull,       ///< compute shaders list the visible instances, and only those are expanded
};

template <>
inline constexpr auto kEnumNames<Instancing> = std::to_array<EnumName<Instancing>>({
    {Instancing::geometry, "geometry"},
    {Instancing::uniform, "uniform"},
    {Instancing::texture, "texture"},
    {Instancing::attribute, "attribute"},
    {Instancing::pull, "pull"},
});

/// How surfels become a picture. The first five ways are those of Slomp et al., Geometry
/// Instancing, Figure 3 (c is the first pass of d); where the paper enlarges, the factor is two.
enum class Splatting {
  regular,           ///< a: one pass with depth, blended in the order of the surfels
  no_depth,          ///< b: the same without depth
  two_pass,          ///< d: a pass for depth, then blending of everything that is not behind it
  enlarged,          ///< e: the same with both passes enlarged
  enlarged_shading,  ///< f: the paper's proposal: only the second pass enlarged
  normalized,        ///< depth first, then the weighted mean of what is not behind it, in any order
};

template <>
inline constexpr auto kEnumNames<Splatting> = std::to_array<EnumName<Splatting>>({
    {Splatting::regular, "regular"},
    {Splatting::no_depth, "no-depth"},
    {Splatting::two_pass, "two-pass"},
    {Splatting::enlarged, "enlarged"},
    {Splatting::enlarged_shading, "enlarged-shading"},
    {Splatting::normalized, "normalized"},
});

/// Factors by which the radii of surfels are multiplied: to decide what is visible, and to blend
/// colours.
struct SplatScales {
  float visibility = 1.0f, shading = 1.0f;

  bool operator==(const SplatScales&) const = default;
};

/// Where the colours of the elements come from.
enum class ColorSource {
  colors,         ///< the frame; plain grey if it has no colours
  normals,        ///< made from the normals, to show which way a surface faces
  plain,          ///< the same light grey everywhere, to show shape by light alone
  curvature,      ///< mean curvature: ridges, valleys and what is flat between them
  accessibility,  ///< how open a place is to what surrounds it
  depth,          ///< the distance from the eye
  contours,       ///< lines of equal height
};

template <>
inline constexpr auto kEnumNames<ColorSource> = std::to_array<EnumName<ColorSource>>({
    {ColorSource::colors, "colors"},
    {ColorSource::normals, "normals"},
    {ColorSource::plain, "plain"},
    {ColorSource::curvature, "curvature"},
    {ColorSource::accessibility, "accessibility"},
    {ColorSource::depth, "depth"},
    {ColorSource::contours, "contours"},
});

/// What lights the scene.
enum class Light {
  flat,         ///< DrawOptions::lighting: a diffuse light over the viewer's shoulder, or none
  studio,       ///< lamps and walls that turn with the viewer
  environment,  ///< DrawOptions::environment, which stands still
};

template <>
inline constexpr auto kEnumNames<Light> = std::to_array<EnumName<Light>>({
    {Light::flat, "flat"},
    {Light::studio, "studio"},
    {Light::environment, "environment"},
});

/// The triangles with which a voxel is drawn.
enum class VoxelShape {
  faces,  ///< the three faces that the eye can see
  cube,   ///< all six, as the paper draws it
};

/// When a window may draw pictures with fewer pixels than it shows, if time is short.
enum class Drafts {
  never,
  moving,   ///< while the user moves the camera or drags the time
  playing,  ///< then, and also while frames play
};

template <>
inline constexpr auto kEnumNames<Drafts> = std::to_array<EnumName<Drafts>>({
    {Drafts::never, "never"},
    {Drafts::moving, "moving"},
    {Drafts::playing, "playing"},
});

/// When surfels that look large are divided (refinement.h).
enum class Refine {
  automatic,  ///< whenever a picture is not urgent
  off,
};

template <>
inline constexpr auto kEnumNames<Refine> = std::to_array<EnumName<Refine>>({
    {Refine::automatic, "auto"},
    {Refine::off, "off"},
});

struct DrawOptions {
  DrawMode mode = DrawMode::surfel;
  Instancing instancing = Instancing::pull;
  Splatting splatting = Splatting::normalized;
  /// Used by Splatting::normalized. The other ways have the paper's scales.
  SplatScales scales{1.4f, 1.4f};
  /// Surfels: close the holes of surfaces, with Splatting::normalized only (reconstruction.h).
  /// Voxels: draw those with which preparing the frame filled gaps (gap_filling.h).
  bool fill_holes = true;
  bool refine = false;  ///< divide surfels that look large (refinement.h)
  ColorSource color = ColorSource::colors;
  VoxelShape voxel_shape = VoxelShape::faces;
  float pixel_size = 1.0f;  ///< edge in pixels below which nodes are not divided; see VoxelCut
  float point_size = 2.0f;  ///< edge of a point in pixels; the least with `adaptive_points`
  /// Points are as large as the distance between neighbours asks for, so that surfaces look closed
  /// (M. Schuetz, "Potree: Rendering Large Point Clouds in Web Browsers", 2016, section 4.2).
  bool adaptive_points = true;
  /// The picture is drawn and read with this many times fewer pixels per side, rounded up, and is
  /// enlarged to its full size when it is shown. 1 to 16.
  int reduction = 1;
  bool smooth_outlines = false;  ///< blend outlines with the background (outlines.h)
  bool lighting = true;  ///< a diffuse light over the viewer's shoulder; false: the plain colours
  float edl = 0.0f;      ///< strength of eye-dome lighting (eye_dome_lighting.h); 0: none
  /// All but flat light is computed for each pixel, once it is known what it shows
  /// (screen_shading.h). Of surfels, only with Splatting::normalized.
  Light light = Light::flat;
  /// For Light::environment; null: the studio.
  std::shared_ptr<const EnvironmentMap> environment = nullptr;
  float roughness = 0.5f;  ///< of surfaces, which widens highlights: kLeastRoughness to 1
  glm::vec3 background{0.11f, 0.12f, 0.14f};      ///< sRGB, 0 to 1
  std::optional<FloorGrid> floor = std::nullopt;  ///< the grid to draw, if any

  bool operator==(const DrawOptions&) const = default;
};

/// The smoothest surface that is drawn: smoother ones would mirror more than a probe holds.
inline constexpr double kLeastRoughness = 0.2;

/// The largest edge of adaptive points, in pixels.
inline constexpr float kLargestPoint = 64.0f;

}  // namespace pointreel
