#pragma once

#include <optional>
#include <vector>

#include <glm/glm.hpp>

#include "client/render/image.h"
#include "client/scene/camera.h"
#include "datasets_synthetic/body.h"
#include "datasets_synthetic/ray_cast.h"
#include "datasets_synthetic/surface_grid.h"
#include "tests/bench/render/image_error.h"

namespace pointreel::bench {

/// A posed figure, ready to be seen.
struct TruthScene {
  Body body;
  SurfaceGrid grid;
};
Result<TruthScene> make_truth_scene(Body body);

/// What a renderer is to come near to: one ray through the centre of each pixel, to the analytic
/// surface. Exact, and so without any smoothing: edges are stairs, and a texture finer than a pixel
/// is one sample of it.
struct TruthPicture {
  Image image;
  Mask mask;  ///< 255 where the ray meets the surface
};

/// How the surface looks.
struct TruthStyle {
  bool texture = true;   ///< the body's colours; else those made from its normals
  bool lighting = true;  ///< as DrawOptions::lighting
  glm::vec3 background{0.11f, 0.12f, 0.14f};  ///< sRGB, as DrawOptions::background
};

/// Lit as the renderer lights (client/render/shaders/common.glsl, `shade`) and on its background,
/// with TBB's threads; about three seconds for 1920x1280 on two. Near and far planes cut nothing.
TruthPicture cast_truth(const TruthScene& scene, const Camera& camera, glm::ivec2 size,
                        const TruthStyle& style);

/// What one pixel's ray meets; the row from the top.
std::optional<RayHit> truth_at(const TruthScene& scene, const Camera& camera, glm::ivec2 size,
                               glm::ivec2 pixel);

/// A surface's colour with light on it, all in linear light.
glm::dvec3 lit(const glm::dvec3& color, const glm::dvec3& normal, const Camera& camera);

double linear_from_srgb(double c);
/// The nearest 8-bit sRGB colour.
glm::u8vec3 srgb_from_linear(const glm::dvec3& color);

/// The share of the picture that the figure covers, from `size` rays.
double truth_coverage(const TruthScene& scene, const Camera& camera, glm::ivec2 size);

/// For each point whether another part of the surface hides it: a ray from the eye meets the
/// surface more than `tolerance` metres before it.
std::vector<bool> hidden_points(const TruthScene& scene, const glm::dvec3& eye,
                                const std::vector<glm::dvec3>& points, double tolerance);

}  // namespace pointreel::bench
