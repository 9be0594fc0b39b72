#pragma once

#include <cstdint>
#include <span>
#include <variant>
#include <vector>

#include <glm/glm.hpp>

#include "pointreel/geometry.h"

namespace pointreel {

/// The signed distance at a point in metres, negative inside, and its gradient.
struct Distance {
  double value = 0.0;
  glm::dvec3 gradient{0.0, 1.0, 0.0};
};

/// The convex hull of two balls; a capsule if the radii are equal. Radii > 0.
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

/// A flat disc with a round rim: all points at most `thickness` from the disc of radius `radius` at
/// right angles to `axis` (unit length). Both are > 0.
struct Disc {
  glm::dvec3 center;
  glm::dvec3 axis;
  double radius, thickness;
};

/// All primitives are convex; ray casting (ray_cast.cpp) relies on that.
using Primitive = std::variant<RoundCone, Ellipsoid, Disc>;

/// The exact distance, inside and outside (to 1e-6 m within a micrometre of the centre of an
/// ellipsoid). If several surface points are equally near, the gradient belongs to one of them. It
/// always has unit length.
Distance distance_to(const RoundCone& cone, const glm::dvec3& p);
Distance distance_to(const Ellipsoid& ellipsoid, const glm::dvec3& p);
Distance distance_to(const Disc& disc, const glm::dvec3& p);
Distance distance_to(const Primitive& primitive, const glm::dvec3& p);

/// The exact bounds of a primitive.
Box bounds(const Primitive& primitive);

/// The quadratic polynomial smooth minimum (Quilez, "Smooth minimum"): the union, with a fillet
/// where the two distances differ by less than `blend` (metres, >= 0; 0 gives the sharp union). The
/// surface moves outwards by at most blend / 4. Like its arguments, the result never changes faster
/// than the position; but inside the fillet it is less than the distance to the surface, and its
/// gradient is shorter than 1 there.
Distance smooth_union(const Distance& a, const Distance& b, double blend);

/// Two primitives that are joined by a fillet, such as the two bones of a joint. A primitive that
/// stands alone is a blend with itself.
struct Blend {
  std::uint16_t first, second;
  double radius;
};

/// The union of all blends. Parts that share no blend, such as an arm and the hip that it swings
/// past, meet in a sharp crease. The order of the blends matters only for ties.
struct Surface {
  std::vector<Primitive> primitives;
  std::vector<Blend> blends;
};

/// The distance from a point to a surface, and the primitive that the point belongs to.
struct SurfaceDistance {
  Distance distance;
  std::uint16_t primitive = 0;  ///< the nearer primitive of the nearest blend
};

/// The distance to the surface, which must have at least one blend.
SurfaceDistance distance_to(const Surface& surface, const glm::dvec3& p);

/// The same for callers that know which blends (at least one) are near.
SurfaceDistance distance_to(const Surface& surface, std::span<const std::uint16_t> blends,
                            const glm::dvec3& p);

/// Writes the distance to each of the given blends into `values`, which is as long as `blends`, and
/// returns the smallest.
double blend_distances(const Surface& surface, std::span<const std::uint16_t> blends,
                       const glm::dvec3& p, std::span<double> values);

/// Bounds that hold the whole surface, including its fillets.
Box bounds(const Surface& surface);

}  // namespace pointreel
