#include "codec/core/placement.h"

#include <array>
#include <cmath>

#include <glm/gtc/constants.hpp>

namespace pointreel {
namespace {

/// Cosine and sine.
glm::dvec2 direction(double degrees) {
  const double turns = degrees / 90.0;
  if (turns == std::floor(turns)) {
    constexpr std::array<std::array<double, 2>, 4> kExact{{{1, 0}, {0, 1}, {-1, 0}, {0, -1}}};
    const auto& exact = kExact[static_cast<std::size_t>(std::fmod(std::fmod(turns, 4) + 4, 4))];
    return {exact[0], exact[1]};
  }
  const double angle = degrees * glm::pi<double>() / 180.0;
  return {std::cos(angle), std::sin(angle)};
}

}  // namespace

glm::dmat3 rotation_of(const glm::dvec3& degrees) {
  const glm::dvec2 x = direction(degrees.x), y = direction(degrees.y), z = direction(degrees.z);
  // By columns.
  const glm::dmat3 about_x(1, 0, 0, 0, x[0], x[1], 0, -x[1], x[0]);
  const glm::dmat3 about_y(y[0], 0, -y[1], 0, 1, 0, y[1], 0, y[0]);
  const glm::dmat3 about_z(z[0], z[1], 0, -z[1], z[0], 0, 0, 0, 1);
  return about_z * about_y * about_x;
}

void place(PointCloud& cloud, const Placement& placement) {
  if (!placement.moves()) return;
  const glm::dmat3 all = placement.scale * placement.rotation;
  cloud.origin = all * cloud.origin;
  for (glm::vec3& p : cloud.positions) p = glm::vec3(all * glm::dvec3(p));
  for (glm::vec3& n : cloud.normals) n = glm::vec3(placement.rotation * glm::dvec3(n));
  for (float& r : cloud.radii) r = static_cast<float>(placement.scale * r);
}

}  // namespace pointreel
