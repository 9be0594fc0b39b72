#include "tests/bench/training/sampled_surface.h"

#include <cstddef>

#include <tbb/parallel_for.h>

#include "datasets_synthetic/trigonometry.h"

namespace pointreel::bench {

void tangents(const glm::dvec3& n, glm::dvec3& u, glm::dvec3& v) {
  const double sign = n.z >= 0.0 ? 1.0 : -1.0, a = -1.0 / (sign + n.z), b = n.x * n.y * a;
  u = {1.0 + sign * n.x * n.x * a, sign * b, -sign * n.x};
  v = {b, sign + n.y * n.y * a, -n.y};
}

glm::dmat3 random_turn(Random& random, bool upright) {
  const double a = 2.0 * kPi * random.uniform();
  const glm::dmat3 about_y(cosine(a), 0, -sine(a), 0, 1, 0, sine(a), 0, cosine(a));
  if (upright) return about_y;
  const double b = 2.0 * kPi * random.uniform(), c = 2.0 * kPi * random.uniform();
  const glm::dmat3 about_x(1, 0, 0, 0, cosine(b), sine(b), 0, -sine(b), cosine(b));
  const glm::dmat3 about_z(cosine(c), sine(c), 0, -sine(c), cosine(c), 0, 0, 0, 1);
  return about_z * about_x * about_y;
}

SampledSurface displaced(const SampledSurface& surface, const Relief& relief) {
  SampledSurface out(surface.size());
  tbb::parallel_for(std::size_t{0}, surface.size(), [&](std::size_t i) {
    const Sample& sample = surface[i];
    out[i] = {sample.position + relief.height(sample.position) * sample.normal, sample.normal};
  });
  return out;
}

}  // namespace pointreel::bench
