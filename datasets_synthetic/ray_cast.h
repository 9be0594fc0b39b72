#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include <glm/glm.hpp>

#include "datasets_synthetic/surface_grid.h"

namespace pointreel {

struct Ray {
  glm::dvec3 origin;
  glm::dvec3 direction;  ///< unit length

  glm::dvec3 at(double t) const { return origin + t * direction; }
};

/// A point where a ray passes through the surface.
struct RayHit {
  double t = 0.0;  ///< metres along the ray
  glm::dvec3 position{0.0};
  glm::dvec3 normal{0.0, 1.0, 0.0};  ///< unit length, pointing outwards even where the ray leaves
  std::uint16_t primitive = 0;
  bool enters = true;  ///< from outside to inside
};

/// The first point where the ray passes through the surface, with t in [from, to]. If the ray
/// begins inside, that is where it leaves. The point is less than 1e-9 m from the surface, hence
/// within 1e-6 m of the exact point unless the angle between ray and tangent plane is below a
/// thousandth of a radian. There is no step size that could skip a part: only a passage that stays
/// within 1e-9 m of the surface is missed.
std::optional<RayHit> first_hit(const SurfaceGrid& grid, const Ray& ray, double from = 0.0,
                                double to = std::numeric_limits<double>::infinity());

/// A point of the surface at origin + depth * way.
struct NearHit {
  double depth = 0.0;
  glm::dvec3 position{0.0};
  glm::dvec3 gradient{0.0};  ///< of the distance: along the normal, but not always of length 1
  std::uint16_t primitive = 0;
};

/// The point where a line of sight enters the surface, if that lies near the place `depth`, by
/// Newton's method; a few times faster than first_hit. What hides the point is not noticed, and a
/// point may be missed. It is within 1e-7 m of the surface where its curvature radius is above
/// 4 mm.
std::optional<NearHit> hit_near(const SurfaceGrid& grid, const glm::dvec3& origin,
                                const glm::dvec3& way, double depth);

/// Whether first_hit would find anything; a little faster.
bool hits_anything(const SurfaceGrid& grid, const Ray& ray, double from, double to);

/// All points where the ray passes through the surface, in order, entering and leaving in turn, as
/// layered depth images store them. Replaces the content of `hits`.
void all_hits(const SurfaceGrid& grid, const Ray& ray, std::vector<RayHit>& hits, double from = 0.0,
              double to = std::numeric_limits<double>::infinity());

}  // namespace pointreel
