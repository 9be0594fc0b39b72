#include "datasets_synthetic/texture.h"

#include <algorithm>
#include <cmath>

#include "datasets_synthetic/random.h"

namespace pointreel {
namespace {

/// A wave between -1 and 1 with a period of 2, made of parabolas.
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
  // Each point of the integer grid has a random number from 0 to 2.
  constexpr std::uint64_t kX = 0x9e3779b97f4a7c15u, kY = 0xc2b2ae3d27d4eb4fu,
                          kZ = 0x165667b19e3779f9u;
  const auto whole = [](double x) {
    return static_cast<std::uint64_t>(static_cast<std::int64_t>(x));
  };
  const std::uint64_t place = seed * 0xd6e8feb86659fd93u + whole(corner.x) * kX +
                              whole(corner.y) * kY + whole(corner.z) * kZ;
  const auto along_x = [&](std::uint64_t at) {
    const auto a = static_cast<double>(static_cast<std::int64_t>(mix_bits(at) >> 11));
    const auto b = static_cast<double>(static_cast<std::int64_t>(mix_bits(at + kX) >> 11));
    return a + s.x * (b - a);
  };
  const auto along_y = [&](std::uint64_t at) {
    const double a = along_x(at), b = along_x(at + kY);
    return a + s.y * (b - a);
  };
  const double a = along_y(place), b = along_y(place + kZ);
  return (a + s.z * (b - a)) * 0x1p-52 - 1.0;
}

double weave(const glm::dvec3& p, double thread) {
  return wave((p.x + p.z) / thread) * wave(p.y / thread);
}

glm::u8vec3 shaded(const glm::u8vec3& color, double change) {
  const glm::dvec3 value = glm::dvec3(color) * (1.0 + change) + 0.5;
  return glm::u8vec3(glm::clamp(value, 0.0, 255.0));
}

}  // namespace pointreel
