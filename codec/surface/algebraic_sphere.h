#pragma once

#include <optional>

#include <glm/glm.hpp>

namespace pointreel {

/// Weighted sums over the points p_i, with unit normals n_i, around a place at which a surface is
/// evaluated. Positions are relative to that place: with coordinates far from zero the differences
/// in the fit would cancel (G. Guennebaud, M. Germann, M. Gross, "Dynamic Sampling and Rendering of
/// Algebraic Point Set Surfaces", 2008, section 3.2; the paper does not say so).
struct SphereSums {
  double w = 0.0;     ///< sum of w_i
  glm::dvec3 p{0.0};  ///< sum of w_i p_i
  glm::dvec3 n{0.0};  ///< sum of w_i n_i
  double pp = 0.0;    ///< sum of w_i (p_i . p_i)
  double pn = 0.0;    ///< sum of w_i (p_i . n_i)

  void add(const glm::dvec3& position, const glm::dvec3& normal, double weight);
};

/// A point on a sphere.
struct SpherePoint {
  glm::dvec3 position{0.0};
  glm::dvec3 normal{0.0};  ///< of unit length
};

/// The sphere u0 + u . x + u4 x . x = 0, a plane where u4 is 0. Coordinates are relative to the
/// place at which it was fitted; the gradient points outwards where the normals do.
struct AlgebraicSphere {
  double u0 = 0.0;
  glm::dvec3 u{0.0};
  double u4 = 0.0;

  /// The point of the sphere that is nearest to `from`, or nothing where the gradient vanishes. If
  /// the sphere has no real point, that of the least algebraic distance along the gradient.
  /// Accurate for every u4, also 0.
  std::optional<SpherePoint> project(const glm::dvec3& from) const;
};

/// The sphere whose gradients fit the normals best, and which then fits the points best (section
/// 3.3, equations 5 and 6, with the missing parenthesis of equation 6 restored). `beta` scales the
/// curvature: 1 is the best sphere, 0 a plane.
///
/// Nothing is returned if the weights are 0 or the normals cancel each other. A single point, or
/// points on one spot, give a plane.
std::optional<AlgebraicSphere> fit_sphere(const SphereSums& sums, double beta);

}  // namespace pointreel
