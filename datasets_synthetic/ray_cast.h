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

/// Where a ray passes through the surface.
struct RayHit {
  double t = 0.0;  ///< metres along the ray
  glm::dvec3 position{0.0};
  glm::dvec3 normal{0.0, 1.0, 0.0};  ///< unit length, outwards, also where the ray leaves
  std::uint16_t primitive = 0;
  bool enters = true;  ///< from outside to inside
};

/// The first point where the ray passes through the surface, t in [from, to]; a ray that begins
/// inside leaves there. Its distance from the surface is below 1e-9 m, so it is within 1e-6 m of
/// the exact point unless the ray is within a thousandth of a radian of the tangent plane. No step
/// size decides what is found: nothing is missed but what stays within 1e-9 m of the surface.
std::optional<RayHit> first_hit(const SurfaceGrid& grid, const Ray& ray, double from = 0.0,
                                double to = std::numeric_limits<double>::infinity());

/// Whether first_hit would find anything; a little faster.
bool hits_anything(const SurfaceGrid& grid, const Ray& ray, double from, double to);

/// All of them in order, entering and leaving in turn: what layered depth images hold. Replaces
/// what `hits` holds.
void all_hits(const SurfaceGrid& grid, const Ray& ray, std::vector<RayHit>& hits, double from = 0.0,
              double to = std::numeric_limits<double>::infinity());

}  // namespace pointreel
