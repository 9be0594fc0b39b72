#pragma once

#include <cstdint>
#include <span>
#include <variant>
#include <vector>

#include <glm/glm.hpp>

#include "pointreel/geometry.h"

namespace pointreel {

/// Signed distance at a point, negative inside, and its gradient. Units are metres.
struct Distance {
  double value = 0.0;
  glm::dvec3 gradient{0.0, 1.0, 0.0};
};

/// The hull of two balls; a capsule where the radii are equal. Radii > 0.
struct RoundCone {
  glm::dvec3 a, b;
  double radius_a, radius_b;
};

/// Radii > 0 along the columns of `axes`, which is a rotation.
struct Ellipsoid {
  glm::dvec3 center;
  glm::dmat3 axes;
  glm::dvec3 radii;
};

/// A flat disc with a round rim: all points at most `thickness` from the disc of `radius` at right
/// angles to `axis` (unit length). Both > 0.
struct Disc {
  glm::dvec3 center;
  glm::dvec3 axis;
  double radius, thickness;
};

/// Every one of them is convex: ray casting (ray_cast.cpp) rests on that.
using Primitive = std::variant<RoundCone, Ellipsoid, Disc>;

/// Exact distance, inside and outside (to 1e-6 within a micrometre of an ellipsoid's centre). Where
/// several surface points are nearest, the gradient is that of one of them; it always has unit
/// length.
Distance distance_to(const RoundCone& cone, const glm::dvec3& p);
Distance distance_to(const Ellipsoid& ellipsoid, const glm::dvec3& p);
Distance distance_to(const Disc& disc, const glm::dvec3& p);
Distance distance_to(const Primitive& primitive, const glm::dvec3& p);

/// Bounds of a primitive, exact.
Box bounds(const Primitive& primitive);

/// The quadratic polynomial smooth minimum (Quilez, "Smooth minimum"): the union with its crease
/// filled where the two distances differ by less than `blend` (metres, >= 0; 0 is the sharp union).
/// The surface moves outwards by at most blend / 4. The result changes by no more than the distance
/// moved, as its arguments do, but inside the fillet it is less than the distance to the surface:
/// there its gradient is shorter than 1.
Distance smooth_union(const Distance& a, const Distance& b, double blend);

/// Two primitives that grow together, as the bones of a joint do. A primitive that stands alone is
/// a blend with itself.
struct Blend {
  std::uint16_t first, second;
  double radius;
};

/// The union of all blends. Parts that are in no blend with each other (an arm and the hip that it
/// swings past) meet in a sharp crease instead of growing together. Independent of the order of the
/// blends but for ties.
struct Surface {
  std::vector<Primitive> primitives;
  std::vector<Blend> blends;
};

/// What is known of a point: where it lies and which primitive it belongs to.
struct SurfaceDistance {
  Distance distance;
  std::uint16_t primitive = 0;  ///< the nearer one of the nearest blend
};

/// The distance to the surface, which has at least one blend.
SurfaceDistance distance_to(const Surface& surface, const glm::dvec3& p);

/// The same for callers who know that only some blends (at least one) are near.
SurfaceDistance distance_to(const Surface& surface, std::span<const std::uint16_t> blends,
                            const glm::dvec3& p);

/// The distance to each of some blends, into `values` (as long as `blends`); returns the smallest.
double blend_distances(const Surface& surface, std::span<const std::uint16_t> blends,
                       const glm::dvec3& p, std::span<double> values);

/// Bounds that hold the whole surface, fillets included.
Box bounds(const Surface& surface);

}  // namespace pointreel
