#include "datasets_synthetic/sdf.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace pointreel {
namespace {

/// Any unit vector at right angles to the unit vector `u`.
glm::dvec3 perpendicular(const glm::dvec3& u) {
  const glm::dvec3 other = std::abs(u.x) < 0.6 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0);
  const glm::dvec3 v = glm::cross(u, other);
  return v / std::sqrt(glm::dot(v, v));
}

Distance distance_to_ball(const glm::dvec3& center, double radius, const glm::dvec3& p) {
  const glm::dvec3 d = p - center;
  const double length = std::sqrt(glm::dot(d, d));
  return {length - radius, length > 0.0 ? d / length : glm::dvec3(0, 1, 0)};
}

/// A cheap lower bound of the distance to an ellipsoid: the largest distance to its oriented box
/// along one axis of the box. For the other primitives, which are cheap themselves, it is minus
/// infinity.
double least_distance_to(const Primitive& primitive, const glm::dvec3& p) {
  const auto* ellipsoid = std::get_if<Ellipsoid>(&primitive);
  if (ellipsoid == nullptr) return -std::numeric_limits<double>::infinity();
  const glm::dvec3 beyond = glm::abs((p - ellipsoid->center) * ellipsoid->axes) - ellipsoid->radii;
  return std::max({beyond.x, beyond.y, beyond.z});
}

/// The distances from one point to primitives. Several blends share a primitive, so each distance
/// is computed only once.
class Memory {
 public:
  Memory(const Surface& surface, const glm::dvec3& p) : surface_(surface), p_(p) {}

  SurfaceDistance distance_to(const Blend& blend) {
    const Distance first = distance_to(blend.first);
    if (blend.first == blend.second) return {first, blend.first};
    // A limb has many folds of which few are near; this saves the evaluation of those that are too
    // far away to matter.
    if (least_distance_to(surface_.primitives[blend.second], p_) - first.value > blend.radius) {
      return {first, blend.first};
    }
    const Distance second = distance_to(blend.second);
    return {smooth_union(first, second, blend.radius),
            first.value <= second.value ? blend.first : blend.second};
  }

 private:
  Distance distance_to(std::uint16_t primitive) {
    for (std::size_t i = 0; i < count_; ++i) {
      if (primitives_[i] == primitive) return distances_[i];
    }
    const Distance distance = pointreel::distance_to(surface_.primitives[primitive], p_);
    if (count_ < primitives_.size()) {
      primitives_[count_] = primitive;
      distances_[count_++] = distance;
    }
    return distance;
  }

  const Surface& surface_;
  const glm::dvec3& p_;
  std::size_t count_ = 0;
  std::array<std::uint16_t, 8> primitives_;
  std::array<Distance, 8> distances_;
};

}  // namespace

// In the half-plane through the axis and p, with x along the axis from a and y >= 0 away from it,
// the side of the body is a straight line with the normal (sine, cosine). The position of a point
// along that line decides whether it belongs to the line or to one of the two balls.
Distance distance_to(const RoundCone& cone, const glm::dvec3& p) {
  const glm::dvec3 axis = cone.b - cone.a;
  const double length = std::sqrt(glm::dot(axis, axis));
  const double difference = cone.radius_a - cone.radius_b;
  if (length <= std::abs(difference)) {  // one ball holds the other
    return difference >= 0.0 ? distance_to_ball(cone.a, cone.radius_a, p)
                             : distance_to_ball(cone.b, cone.radius_b, p);
  }
  const glm::dvec3 u = axis / length;
  const double sine = difference / length;
  const double cosine = std::sqrt(1.0 - sine * sine);
  const double x = glm::dot(p - cone.a, u);
  const glm::dvec3 away = p - cone.a - x * u;
  const double y = std::sqrt(glm::dot(away, away));
  const double along = x * cosine - y * sine;
  if (along <= 0.0) return distance_to_ball(cone.a, cone.radius_a, p);
  if (along >= length * cosine) return distance_to_ball(cone.b, cone.radius_b, p);
  const glm::dvec3 radial = y > 0.0 ? away / y : perpendicular(u);
  return {x * sine + y * cosine - cone.radius_a, sine * u + cosine * radial};
}

// The point x of the surface that is nearest to q satisfies q_i = x_i + t * x_i / r_i^2, so x_i =
// r_i^2 q_i / (t + r_i^2), and t is the largest root of sum (r_i q_i / (t + r_i^2))^2 = 1 (Eberly,
// "Distance from a point to an ellipse, an ellipsoid, or a hyperellipsoid"). To the right of the
// last pole, the inverse square root of that sum is concave and almost straight (exactly straight
// for a ball). A step of Newton's method on it from anywhere there ends to the left of the root,
// and from there a few steps climb to the root (More, Sorensen, "Computing a trust region step").
// The first step starts at t = 0, which is the root for points on the surface.
Distance distance_to(const Ellipsoid& ellipsoid, const glm::dvec3& p) {
  const glm::dvec3 local = (p - ellipsoid.center) * ellipsoid.axes;  // transpose(axes) * (p - c)
  const glm::dvec3 r = ellipsoid.radii;
  // With a coordinate of exactly zero the sum could lack its last pole.
  const glm::dvec3 q = glm::max(glm::abs(local), glm::dvec3(1e-12));
  const glm::dvec3 squares = r * r;
  // At this t a single term is already 1, so the root is not to the left of it.
  const double lowest =
      std::max({r.x * q.x - squares.x, r.y * q.y - squares.y, r.z * q.z - squares.z});
  double t = 0.0;
  for (int step = 0; step < 100; ++step) {
    const glm::dvec3 inverse = 1.0 / (t + squares);
    const glm::dvec3 ratio = r * q * inverse;
    const double sum = glm::dot(ratio, ratio);
    t = std::max(t + sum * (std::sqrt(sum) - 1.0) / glm::dot(ratio * ratio, inverse), lowest);
    if (std::abs(sum - 1.0) < 1e-6) break;  // the last step has squared this small error
  }
  const glm::dvec3 nearest = squares * q / (t + squares);
  const glm::dvec3 across = q - nearest;
  const double distance = std::sqrt(glm::dot(across, across));
  glm::dvec3 normal = nearest / squares;
  normal /= std::sqrt(glm::dot(normal, normal));
  for (int axis = 0; axis < 3; ++axis) {
    if (local[axis] < 0.0) normal[axis] = -normal[axis];
  }
  return {t < 0.0 ? -distance : distance, ellipsoid.axes * normal};
}

// The flat disc has no inside, so the distance to it minus the thickness is exact.
Distance distance_to(const Disc& disc, const glm::dvec3& p) {
  const glm::dvec3 from_center = p - disc.center;
  const double height = glm::dot(from_center, disc.axis);
  const glm::dvec3 across = from_center - height * disc.axis;
  const double square = glm::dot(across, across);
  const double share = square > disc.radius * disc.radius ? disc.radius / std::sqrt(square) : 1.0;
  const glm::dvec3 away = from_center - share * across;
  const double length = std::sqrt(glm::dot(away, away));
  return {length - disc.thickness, length > 0.0 ? away / length : disc.axis};
}

Distance distance_to(const Primitive& primitive, const glm::dvec3& p) {
  // This is faster than std::visit.
  if (const auto* cone = std::get_if<RoundCone>(&primitive)) return distance_to(*cone, p);
  if (const auto* disc = std::get_if<Disc>(&primitive)) return distance_to(*disc, p);
  return distance_to(*std::get_if<Ellipsoid>(&primitive), p);
}

Box bounds(const Primitive& primitive) {
  Box box;
  if (const auto* cone = std::get_if<RoundCone>(&primitive)) {
    box.grow(cone->a - cone->radius_a);
    box.grow(cone->a + cone->radius_a);
    box.grow(cone->b - cone->radius_b);
    box.grow(cone->b + cone->radius_b);
  } else if (const auto* ellipsoid = std::get_if<Ellipsoid>(&primitive)) {
    glm::dvec3 reach;
    for (int axis = 0; axis < 3; ++axis) {
      const glm::dvec3 row =
          glm::dvec3(ellipsoid->axes[0][axis], ellipsoid->axes[1][axis], ellipsoid->axes[2][axis]) *
          ellipsoid->radii;
      reach[axis] = std::sqrt(glm::dot(row, row));
    }
    box.grow(ellipsoid->center - reach);
    box.grow(ellipsoid->center + reach);
  } else if (const auto* disc = std::get_if<Disc>(&primitive)) {
    glm::dvec3 reach;
    for (int axis = 0; axis < 3; ++axis) {
      const double a = disc->axis[axis];
      reach[axis] = disc->radius * std::sqrt(std::max(0.0, 1.0 - a * a)) + disc->thickness;
    }
    box.grow(disc->center - reach);
    box.grow(disc->center + reach);
  }
  return box;
}

Distance smooth_union(const Distance& a, const Distance& b, double blend) {
  const Distance& near = a.value <= b.value ? a : b;
  const Distance& far = a.value <= b.value ? b : a;
  const double overlap = blend - (far.value - near.value);
  if (!(overlap > 0.0)) return near;
  const double share = overlap / blend;
  return {near.value - 0.25 * overlap * share,
          (1.0 - 0.5 * share) * near.gradient + 0.5 * share * far.gradient};
}

SurfaceDistance distance_to(const Surface& surface, const glm::dvec3& p) {
  std::vector<std::uint16_t> all(surface.blends.size());
  for (std::size_t i = 0; i < all.size(); ++i) all[i] = static_cast<std::uint16_t>(i);
  return distance_to(surface, all, p);
}

SurfaceDistance distance_to(const Surface& surface, std::span<const std::uint16_t> blends,
                            const glm::dvec3& p) {
  Memory memory(surface, p);
  SurfaceDistance nearest;
  nearest.distance.value = std::numeric_limits<double>::infinity();
  for (const std::uint16_t number : blends) {
    const SurfaceDistance candidate = memory.distance_to(surface.blends[number]);
    if (candidate.distance.value < nearest.distance.value) nearest = candidate;
  }
  return nearest;
}

double blend_distances(const Surface& surface, std::span<const std::uint16_t> blends,
                       const glm::dvec3& p, std::span<double> values) {
  Memory memory(surface, p);
  double nearest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < blends.size(); ++i) {
    values[i] = memory.distance_to(surface.blends[blends[i]]).distance.value;
    nearest = std::min(nearest, values[i]);
  }
  return nearest;
}

Box bounds(const Surface& surface) {
  Box box;
  double fillet = 0.0;
  for (const Primitive& primitive : surface.primitives) box.grow(bounds(primitive));
  for (const Blend& blend : surface.blends) fillet = std::max(fillet, 0.25 * blend.radius);
  if (!box.empty()) {
    box.min -= fillet;
    box.max += fillet;
  }
  return box;
}

}  // namespace pointreel
