#pragma once

#include <algorithm>
#include <cmath>

#include <glm/glm.hpp>

#include "datasets_synthetic/sdf.h"

namespace pointreel {

/// value + slope * s: a distance and its change along a ray.
struct RayLine {
  double value = 0.0, slope = 0.0;

  double at(double s) const { return value + slope * s; }
};

/// A primitive prepared for many evaluations. Near the surface and outside, its distances equal
/// those of distance_to except for rounding (to 1e-8 m near the axis of a cone), and they are a few
/// times faster.
class RayPrimitive {
 public:
  explicit RayPrimitive(const Primitive& primitive) {
    if (const auto* cone = std::get_if<RoundCone>(&primitive)) {
      prepare(*cone);
    } else if (const auto* ellipsoid = std::get_if<Ellipsoid>(&primitive)) {
      kind_ = Kind::ellipsoid;
      a_ = ellipsoid->center;
      axes_ = ellipsoid->axes;
      radii_ = ellipsoid->radii;
      squares_ = radii_ * radii_;
    } else if (const auto* disc = std::get_if<Disc>(&primitive)) {
      kind_ = Kind::disc;
      a_ = disc->center;
      u_ = disc->axis;
      radius_a_ = disc->radius;
      radius_b_ = disc->thickness;
    }
  }

  /// The distance at p and its change along the unit vector `direction`.
  RayLine along(const glm::dvec3& p, const glm::dvec3& direction) const {
    const glm::dvec3 d = p - a_;
    if (kind_ == Kind::ellipsoid) return along_ellipsoid(d, direction);
    if (kind_ == Kind::ball) return along_ball(d, direction, radius_a_);
    if (kind_ == Kind::disc) {
      const Distance at = at_disc(d);
      return {at.value, glm::dot(at.gradient, direction)};
    }
    const double x = glm::dot(d, u_);
    const double y = std::sqrt(std::max(glm::dot(d, d) - x * x, 0.0));
    const double place = x * cosine_ - y * sine_;
    if (place <= 0.0) return along_ball(d, direction, radius_a_);
    if (place >= end_) return along_ball(p - b_, direction, radius_b_);
    const double across = glm::dot(u_, direction);
    const double away = y > 0.0 ? (glm::dot(d, direction) - x * across) / y : 0.0;
    return {x * sine_ + y * cosine_ - radius_a_, sine_ * across + cosine_ * away};
  }

  /// The distance at p.
  double value(const glm::dvec3& p) const {
    const glm::dvec3 d = p - a_;
    if (kind_ == Kind::ellipsoid) return nearest_of_ellipsoid(d).distance;
    if (kind_ == Kind::ball) return std::sqrt(glm::dot(d, d)) - radius_a_;
    if (kind_ == Kind::disc) return at_disc(d).value;
    const double x = glm::dot(d, u_);
    const double y = std::sqrt(std::max(glm::dot(d, d) - x * x, 0.0));
    const double place = x * cosine_ - y * sine_;
    if (place <= 0.0) return std::sqrt(glm::dot(d, d)) - radius_a_;
    const glm::dvec3 e = p - b_;
    if (place >= end_) return std::sqrt(glm::dot(e, e)) - radius_b_;
    return x * sine_ + y * cosine_ - radius_a_;
  }

  /// The distance at p with its gradient.
  Distance at(const glm::dvec3& p) const {
    const glm::dvec3 d = p - a_;
    if (kind_ == Kind::ellipsoid) {
      const EllipsoidPoint nearest = nearest_of_ellipsoid(d);
      return {nearest.distance, axes_ * nearest.normal};
    }
    if (kind_ == Kind::ball) return at_ball(d, radius_a_);
    if (kind_ == Kind::disc) return at_disc(d);
    const double x = glm::dot(d, u_);
    const glm::dvec3 away = d - x * u_;
    const double y = std::sqrt(glm::dot(away, away));
    const double place = x * cosine_ - y * sine_;
    if (place <= 0.0) return at_ball(d, radius_a_);
    if (place >= end_) return at_ball(p - b_, radius_b_);
    const glm::dvec3 radial = y > 0.0 ? away / y : glm::dvec3(0.0);
    return {x * sine_ + y * cosine_ - radius_a_, sine_ * u_ + cosine_ * radial};
  }

 private:
  enum class Kind { ball, cone, ellipsoid, disc };

  void prepare(const RoundCone& cone) {
    const glm::dvec3 axis = cone.b - cone.a;
    const double length = std::sqrt(glm::dot(axis, axis));
    const double difference = cone.radius_a - cone.radius_b;
    kind_ = length <= std::abs(difference) ? Kind::ball : Kind::cone;
    const bool swap = kind_ == Kind::ball && difference < 0.0;
    a_ = swap ? cone.b : cone.a;
    b_ = swap ? cone.a : cone.b;
    radius_a_ = swap ? cone.radius_b : cone.radius_a;
    radius_b_ = swap ? cone.radius_a : cone.radius_b;
    if (kind_ == Kind::ball) return;
    u_ = axis / length;
    sine_ = difference / length;
    cosine_ = std::sqrt(1.0 - sine_ * sine_);
    end_ = length * cosine_;
  }

  static Distance at_ball(const glm::dvec3& d, double radius) {
    const double length = std::sqrt(glm::dot(d, d));
    return {length - radius, length > 0.0 ? d / length : glm::dvec3(0, 1, 0)};
  }

  static RayLine along_ball(const glm::dvec3& d, const glm::dvec3& direction, double radius) {
    const double length = std::sqrt(glm::dot(d, d));
    return {length - radius, length > 0.0 ? glm::dot(d, direction) / length : 1.0};
  }

  /// The same as distance_to(Disc) in sdf.cpp.
  Distance at_disc(const glm::dvec3& d) const {
    const glm::dvec3 across = d - glm::dot(d, u_) * u_;
    const double square = glm::dot(across, across);
    const double share = square > radius_a_ * radius_a_ ? radius_a_ / std::sqrt(square) : 1.0;
    return at_ball(d - share * across, radius_b_);
  }

  RayLine along_ellipsoid(const glm::dvec3& d, const glm::dvec3& direction) const {
    const EllipsoidPoint nearest = nearest_of_ellipsoid(d);
    return {nearest.distance, glm::dot(nearest.normal, direction * axes_)};
  }

  struct EllipsoidPoint {
    double distance;
    glm::dvec3 normal;  // unit length, along the ellipsoid's axes
  };

  /// The same as distance_to(Ellipsoid), which is explained in sdf.cpp.
  EllipsoidPoint nearest_of_ellipsoid(const glm::dvec3& d) const {
    const glm::dvec3 local = d * axes_;
    const glm::dvec3 q = glm::max(glm::abs(local), glm::dvec3(1e-12));
    const glm::dvec3 rq = radii_ * q;
    const glm::dvec3 poles = rq - squares_;
    const double lowest = std::max({poles.x, poles.y, poles.z});
    double t = 0.0;
    for (int step = 0; step < 100; ++step) {
      const glm::dvec3 inverse = 1.0 / (t + squares_);
      const glm::dvec3 ratio = rq * inverse;
      const double sum = glm::dot(ratio, ratio);
      t = std::max(t + sum * (std::sqrt(sum) - 1.0) / glm::dot(ratio * ratio, inverse), lowest);
      if (std::abs(sum - 1.0) < 1e-6) break;
    }
    // The point of the surface is squares * n, and n is parallel to the normal there.
    const glm::dvec3 n = q / (t + squares_);
    const glm::dvec3 across = q - squares_ * n;
    const double distance = std::sqrt(glm::dot(across, across));
    glm::dvec3 normal = n / std::sqrt(glm::dot(n, n));
    for (int axis = 0; axis < 3; ++axis) {
      if (local[axis] < 0.0) normal[axis] = -normal[axis];
    }
    return {t < 0.0 ? -distance : distance, normal};
  }

  Kind kind_ = Kind::ball;
  glm::dvec3 a_{0.0}, b_{0.0}, u_{0.0};
  double radius_a_ = 0.0, radius_b_ = 0.0, sine_ = 0.0, cosine_ = 1.0, end_ = 0.0;
  glm::dmat3 axes_{1.0};
  glm::dvec3 radii_{1.0}, squares_{1.0};
};

}  // namespace pointreel
