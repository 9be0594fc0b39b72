#pragma once

#include <array>

#include <glm/glm.hpp>

#include "client/render/light_probe.h"
#include "client/render/region.h"
#include "client/scene/camera.h"
#include "client/scene/draw_options.h"

namespace pointreel {

/// Whether pixels are shaded after all is drawn, from their normals and depths.
bool is_shaded_late(const DrawOptions& options);

/// How the key light sees a scene, in a square map around all instances.
inline constexpr int kShadowEdge = 256;

/// What shading pixels needs, in the coordinates of the instances. The layout is that of the
/// Shading block of shading.glsl.
struct ShadingView {
  glm::mat4 to_environment;  ///< rotates directions of the scene
  /// To the map of the key light: x and y from 0 to 1, z from 0 to 1 towards the light.
  glm::mat4 to_shadow;
  std::array<glm::vec4, 9> diffuse;  ///< LightProbe::diffuse
  glm::vec4 key_direction;           ///< xyz: in the scene; w: z of shadow that is not one
  glm::vec4 key;                     ///< rgb: LightProbe::key; w: roughness
  glm::vec4 up;                      ///< xyz: up in the scene; w: the height of the floor
  /// x: how far what surrounds a point takes light from it; y: radius of a sphere around all
  /// instances; z: the number of a ColorSource that is found for each pixel, or 0; w: 1 and 0 with
  /// and without the light over the viewer's shoulder, kLateLight with any other light.
  glm::vec4 reach;
  /// x: distance between contours; y: height of the origin above one of them; z, w: the least and
  /// the largest depth of instances.
  glm::vec4 scale;
};
inline constexpr float kLateLight = 2.0f;

/// `bounds` are those of the instances, which are relative to `origin`.
ShadingView make_shading(const DrawOptions& options, const LightProbe& probe, const Camera& camera,
                         const InstanceBounds& bounds, const glm::dvec3& origin);

// The numbers by which renderers shade.

/// The share of the light of a variance shadow map that is taken for light that leaks.
inline constexpr float kLeak = 0.25f;

/// How much of the floor's light a shadow takes.
inline constexpr float kFloorShadow = 0.65f;
/// The light that a surface reflects of what comes straight at it, as most materials do.
inline constexpr float kReflectance = 0.04f;
/// How strongly what surrounds a point takes light from it.
inline constexpr float kOcclusion = 2.0f;

/// The least cosine between the normal of a pixel and the direction to the eye.
inline constexpr float kLeastFacing = 0.05f;

/// How far away a point looks for how its normals turn, as a share of the sphere around all
/// instances; the least and most distance in pixels; and the curvature of that sphere that looks
/// half as strong as any can.
inline constexpr float kBend = 0.012f, kLeastBend = 2.0f, kMostBend = 24.0f, kHalfBend = 25.0f;

/// Directions in which a point looks for what surrounds it, and the most and least distance that it
/// looks at, in pixels and as a share of the picture's height.
inline constexpr int kTaps = 12;
inline constexpr float kLeastReach = 3.0f, kMostReach = 0.12f;
/// Around the tap with number i: its distance as a share of the whole, and its direction.
/// `turn` is 0 to 3.
glm::vec2 tap(int i, int turn);

}  // namespace pointreel