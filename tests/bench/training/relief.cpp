#include "tests/bench/training/relief.h"

#include <cmath>

namespace pointreel::bench {
namespace {

double lattice_value(std::int64_t x, std::int64_t y, std::int64_t z, std::uint64_t seed) {
  std::uint64_t h = seed ^ static_cast<std::uint64_t>(x) * 0x9e3779b97f4a7c15u;
  h = (h ^ h >> 29) * 0xbf58476d1ce4e5b9u + static_cast<std::uint64_t>(y);
  h = (h ^ h >> 31) * 0x94d049bb133111ebu + static_cast<std::uint64_t>(z);
  h = (h ^ h >> 30) * 0xbf58476d1ce4e5b9u;
  h ^= h >> 32;
  return static_cast<double>(h & 0xffffffu) * (2.0 / 0xffffff) - 1.0;
}

double mix(double a, double b, double t) { return a + t * (b - a); }

}  // namespace

double lattice_noise(const glm::dvec3& p, std::uint64_t seed) {
  const glm::dvec3 cell = glm::floor(p), t = p - cell, s = t * t * (3.0 - 2.0 * t);
  const auto x = static_cast<std::int64_t>(cell.x), y = static_cast<std::int64_t>(cell.y),
             z = static_cast<std::int64_t>(cell.z);
  double planes[2];
  for (int i = 0; i < 2; ++i) {
    const double a =
        mix(lattice_value(x, y, z + i, seed), lattice_value(x + 1, y, z + i, seed), s.x);
    const double b =
        mix(lattice_value(x, y + 1, z + i, seed), lattice_value(x + 1, y + 1, z + i, seed), s.x);
    planes[i] = mix(a, b, s.y);
  }
  return mix(planes[0], planes[1], s.z);
}

Relief Relief::fractal(double longest, double shortest, double amplitude, double decay,
                       double creased_share, Random& random) {
  Relief relief;
  relief.seed_ = random.bits();
  for (double wavelength = longest; wavelength >= shortest; wavelength *= 0.5) {
    const bool creased = random.uniform() < creased_share;
    // Folds are longer along one axis than along the others.
    glm::dvec3 frequency(1.0 / wavelength);
    if (creased) frequency[static_cast<int>(random.below(3))] *= 0.3;
    relief.octaves_.push_back({frequency, amplitude, creased});
    // 2^-decay for a decay that is a multiple of 1/4, without pow, which differs between machines.
    double factor = 1.0;
    for (double d = decay; d > 0.0; d -= 0.25) factor *= 0.84089641525371454;
    amplitude *= factor;
  }
  return relief;
}

double Relief::height(const glm::dvec3& p) const {
  double sum = 0.0;
  for (std::size_t i = 0; i < octaves_.size(); ++i) {
    const double noise = lattice_noise(p * octaves_[i].frequency, seed_ + i);
    const double shape = octaves_[i].creased ? 1.0 - 4.0 * std::abs(noise) : noise;
    sum += octaves_[i].amplitude * shape;
  }
  return sum;
}

}  // namespace pointreel::bench
