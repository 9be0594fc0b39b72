#include "tests/bench/clouds.h"

#include <cmath>
#include <random>

namespace pointreel::bench {
namespace {

/// A point on a bumpy surface that is about as tall and as thin as a person.
glm::dvec3 surface(double turn, double height) {
  const double radius = 0.12 + 0.10 * std::sin(3.14159265 * height) +
                        0.02 * std::sin(7 * turn + 11 * height) + 0.01 * std::sin(29 * height);
  return {radius * std::cos(turn), 1.8 * height, radius * std::sin(turn)};
}

}  // namespace

PointCloud scan_like_cloud(std::size_t n) {
  // Half of the points lie on upright curves and half on level ones. The spacing along a curve is a
  // third of the distance between curves.
  constexpr double kTwoPi = 2.0 * 3.14159265, kSpacingRatio = 3.0;
  const double aspect = 1.8 / (kTwoPi * 0.2);  // height over girth
  const double half = static_cast<double>(n) / 2.0;
  const double upright = std::floor(std::sqrt(half / kSpacingRatio / aspect));
  const double level = std::floor(std::sqrt(half / kSpacingRatio * aspect));
  std::mt19937_64 random(1);
  const auto uniform = [&random] { return static_cast<double>(random() >> 11) * 0x1p-53; };

  PointCloud cloud;
  for (std::size_t i = 0; i < n; ++i) {
    // The points of each kind are spread evenly over the curves of that kind.
    const double place = std::floor(static_cast<double>(i) / 2.0) / half;
    const double curves = i % 2 == 0 ? upright : level;
    const double curve = std::floor(place * curves);
    const double along = place * curves - curve + 0.3 * uniform() * curves / half;
    const double across = (curve + 0.02 * uniform()) / curves;
    const double turn = kTwoPi * (i % 2 == 0 ? across : along);
    const double height = i % 2 == 0 ? along : across;
    const glm::dvec3 p = surface(turn, height);
    const glm::dvec3 round = surface(turn + 1e-4, height) - p,
                     up = surface(turn, height + 1e-4) - p;
    const glm::dvec3 normal = glm::normalize(glm::cross(up, round));
    const double noise = 0.001 * (uniform() + uniform() + uniform() - 1.5);
    cloud.positions.push_back(glm::vec3(p + noise * normal));
    cloud.normals.push_back(glm::vec3(normal));
    const glm::dvec3 color = 127.5 * (1.0 + glm::sin(glm::dvec3(9, 14, 5) * p));
    cloud.colors.push_back(glm::u16vec3(glm::round(color)) * std::uint16_t{257});
  }
  return cloud;
}

}  // namespace pointreel::bench
