#include "codec/surface/algebraic_sphere.h"

#include <algorithm>
#include <cmath>

namespace pointreel {
namespace {

/// Below this share of the sum of squares, their spread consists of rounding errors.
constexpr double kRounding = 1e-9;
/// The least length of the mean normal at which it has a direction.
constexpr double kLeastNormal = 1e-6;

}  // namespace

void SphereSums::add(const glm::dvec3& position, const glm::dvec3& normal, double weight) {
  w += weight;
  p += weight * position;
  n += weight * normal;
  pp += weight * glm::dot(position, position);
  pn += weight * glm::dot(position, normal);
}

std::optional<SpherePoint> AlgebraicSphere::project(const glm::dvec3& from) const {
  const glm::dvec3 gradient = u + 2.0 * u4 * from;
  const double slope = glm::length(gradient);
  if (!(slope > 0.0)) return std::nullopt;
  const double value = u0 + glm::dot(u, from) + u4 * glm::dot(from, from);
  // The root of value + slope t + u4 t^2 that is nearest to 0, without the centre and the radius,
  // which are infinite for a plane.
  const double discriminant = std::max(0.0, slope * slope - 4.0 * u4 * value);
  const double t = -2.0 * value / (slope + std::sqrt(discriminant));
  SpherePoint found;
  found.position = from + gradient * (t / slope);
  found.normal = gradient * (1.0 + 2.0 * u4 * t / slope);
  const double length = glm::length(found.normal);
  // At the centre of a sphere every direction is normal; the one that leads there serves as well.
  found.normal = length > 1e-9 * slope ? found.normal / length : gradient / slope;
  return found;
}

std::optional<AlgebraicSphere> fit_sphere(const SphereSums& sums, double beta) {
  if (!(sums.w > 0.0)) return std::nullopt;
  const glm::dvec3 p = sums.p / sums.w, n = sums.n / sums.w;
  if (!(glm::dot(n, n) > kLeastNormal * kLeastNormal)) return std::nullopt;
  AlgebraicSphere sphere;
  const double spread = sums.pp - glm::dot(p, sums.p);
  if (spread > kRounding * sums.pp) {
    sphere.u4 = 0.5 * beta * (sums.pn - glm::dot(p, sums.n)) / spread;
  }
  sphere.u = n - 2.0 * sphere.u4 * p;
  sphere.u0 = -glm::dot(sphere.u, p) - sphere.u4 * sums.pp / sums.w;
  return sphere;
}

}  // namespace pointreel
