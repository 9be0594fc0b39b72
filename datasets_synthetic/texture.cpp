#include "datasets_synthetic/texture.h"

#include <algorithm>
#include <cmath>

#include "datasets_synthetic/random.h"

namespace pointreel {
namespace {

/// A random number, -1 to 1, that belongs to a place of the integer grid.
double at_corner(const glm::dvec3& corner, std::uint64_t seed) {
  const auto bits = [](double x) {
    return static_cast<std::uint64_t>(static_cast<std::int64_t>(x)) & 0x1fffffu;
  };
  const std::uint64_t place = bits(corner.x) | bits(corner.y) << 21 | bits(corner.z) << 42;
  return 2.0 * Random(seed, place).uniform() - 1.0;
}

/// Up and down between -1 and 1 with the period 2, from parabolas.
double wave(double x) {
  const double t = x - 2.0 * std::floor(0.5 * x);  // 0 to 2
  const double half = t < 1.0 ? t : t - 1.0;
  const double bow = 4.0 * half * (1.0 - half);
  return t < 1.0 ? bow : -bow;
}

}  // namespace

double value_noise(const glm::dvec3& p, std::uint64_t seed) {
  const glm::dvec3 corner(std::floor(p.x), std::floor(p.y), std::floor(p.z));
  glm::dvec3 s = p - corner;
  s = s * s * (3.0 - 2.0 * s);
  double sum = 0.0;
  for (unsigned i = 0; i < 8; ++i) {
    const glm::dvec3 step(i & 1u, (i >> 1) & 1u, (i >> 2) & 1u);
    const glm::dvec3 weight = step * s + (1.0 - step) * (1.0 - s);
    sum += weight.x * weight.y * weight.z * at_corner(corner + step, seed);
  }
  return sum;
}

double weave(const glm::dvec3& p, double thread) {
  return wave((p.x + p.z) / thread) * wave(p.y / thread);
}

glm::u8vec3 shaded(const glm::u8vec3& color, double change) {
  const glm::dvec3 value = glm::dvec3(color) * (1.0 + change) + 0.5;
  return glm::u8vec3(glm::clamp(value, 0.0, 255.0));
}

}  // namespace pointreel
