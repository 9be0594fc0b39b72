#include "tests/bench/training/terrain.h"

#include <cmath>
#include <cstdint>

#include "datasets_synthetic/trigonometry.h"
#include "tests/bench/training/relief.h"

namespace pointreel::bench {

SampledSurface terrain(std::size_t count, Random& random) {
  const Relief relief = Relief::fractal(0.7, 0.001, 0.08, 1.0, 0.3, random);
  SampledSurface surface(count);
  for (Sample& sample : surface) {
    const double x = random.uniform(), y = random.uniform();
    sample = {{x, y, relief.height({x, y, 0.5})}, {0, 0, 1}};
  }
  return surface;
}

SampledSurface flown_over(const SampledSurface& ground, double line, double vegetation,
                          Random& random) {
  const std::uint64_t seed = random.bits();
  SampledSurface out;
  for (Sample sample : ground) {
    const double lines = sample.position.x / line;
    const double spread = 0.25 * random.uniform();
    sample.position.x = line * (std::floor(lines) + spread * random.normal());
    const double wood = lattice_noise(sample.position * 9.0, seed) - 0.1;
    if (wood > 0.0 && random.uniform() < vegetation) {
      const double top = 0.01 + 0.03 * wood;
      sample.position.z += top * random.uniform();
    }
    out.push_back(sample);
  }
  return out;
}

SampledSurface built_up(SampledSurface ground, Random& random) {
  const std::uint64_t seed = random.bits();
  for (Sample& sample : ground) {
    const glm::dvec3 block = glm::floor(sample.position * 14.0);
    const double kind = lattice_noise({block.x, block.y, 0.5}, seed);
    const glm::dvec3 in = sample.position * 14.0 - block;
    if (kind < 0.25 || in.x < 0.2 || in.x > 0.7 || in.y < 0.3 || in.y > 0.8) continue;
    const double height = 0.008 + 0.02 * kind;
    const bool wall = in.x > 0.68 && random.uniform() < 0.4;
    sample.position.z = 0.05 + (wall ? height * random.uniform() : height);
  }
  const double a = 2.0 * kPi * random.uniform();
  for (Sample& sample : ground) {
    const glm::dvec3 p = sample.position;
    sample.position = {cosine(a) * p.x - sine(a) * p.y, sine(a) * p.x + cosine(a) * p.y, p.z};
  }
  return ground;
}

}  // namespace pointreel::bench
