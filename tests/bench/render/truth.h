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

/// A posed figure, ready for casting rays.
struct TruthScene {
  Body body;
  SurfaceGrid grid;
};
Result<TruthScene> make_truth_scene(Body body);

/// The picture that renderers should approach: a ray through the centre of each pixel to the
/// analytic surface. It is exact and therefore not smoothed: edges have steps, and a texture that
/// is finer than a pixel is sampled at one point.
struct TruthPicture {
  Image image;
  Mask mask;  ///< 255 where the ray meets the surface
};

/// The appearance of the surface.
struct TruthStyle {
  bool texture = true;   ///< the colours of the body; false: colours made from its normals
  bool lighting = true;  ///< as DrawOptions::lighting
  glm::vec3 background{0.11f, 0.12f, 0.14f};  ///< sRGB, as DrawOptions::background
};

/// Casts the rays of a picture on all threads of TBB, which takes about three seconds for 1920x1280
/// on two threads. The surface is lit as by the renderer (light_on in common.glsl). There is no
/// near plane.
TruthPicture cast_truth(const TruthScene& scene, const Camera& camera, glm::ivec2 size,
                        const TruthStyle& style);

/// The hit of the ray through a pixel, counted from the upper left corner.
std::optional<RayHit> truth_at(const TruthScene& scene, const Camera& camera, glm::ivec2 size,
                               glm::ivec2 pixel);

/// The colour of a lit surface, in linear light. `strength`: light_strength (client/render/view.h).
glm::dvec3 lit(const glm::dvec3& color, const glm::dvec3& normal, const Camera& camera,
               double strength);

double linear_from_srgb(double c);
/// The nearest colour in 8-bit sRGB.
glm::u8vec3 srgb_from_linear(const glm::dvec3& color);

/// The share of a picture of this size that the figure covers.
double truth_coverage(const TruthScene& scene, const Camera& camera, glm::ivec2 size);

/// Whether another part of the surface hides each point, that is, whether the ray from the eye
/// meets the surface more than `tolerance` metres before the point.
std::vector<bool> hidden_points(const TruthScene& scene, const glm::dvec3& eye,
                                const std::vector<glm::dvec3>& points, double tolerance);

}  // namespace pointreel::bench
