#include "tests/bench/training/sensors.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "datasets_synthetic/trigonometry.h"
#include "tests/bench/training/relief.h"

namespace pointreel::bench {

SampledSurface filled(const SampledSurface& surface, double spacing) {
  SampledSurface out;
  out.reserve(5 * surface.size());
  for (const Sample& sample : surface) {
    glm::dvec3 u, v;
    tangents(sample.normal, u, v);
    out.push_back(sample);
    for (const glm::dvec3& d : {u, -u, v, -v}) {
      out.push_back({sample.position + spacing * d, sample.normal});
    }
  }
  return out;
}

SampledSurface first(const SampledSurface& surface, std::size_t count) {
  return {surface.begin(),
          surface.begin() + static_cast<std::ptrdiff_t>(std::min(count, surface.size()))};
}

SampledSurface spaced(const SampledSurface& surface, double distance, double variation,
                      Random& random) {
  constexpr std::size_t kBuckets = 1u << 20;
  const std::uint64_t seed = random.bits();
  const double cell = distance * (1.0 + variation);
  std::vector<std::uint32_t> head(kBuckets, ~0u), next;
  SampledSurface out;
  const auto bucket = [](const glm::ivec3& c) {
    return (static_cast<std::uint32_t>(c.x) * 73856093u ^
            static_cast<std::uint32_t>(c.y) * 19349663u ^
            static_cast<std::uint32_t>(c.z) * 83492791u) %
           kBuckets;
  };
  for (const Sample& sample : surface) {
    const glm::ivec3 at(glm::floor(sample.position / cell));
    const double here = distance * (1.0 + variation * lattice_noise(sample.position * 12.0, seed));
    bool apart = true;
    for (int i = 0; i < 27 && apart; ++i) {
      const glm::ivec3 around = at + glm::ivec3(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1);
      for (std::uint32_t other = head[bucket(around)]; other != ~0u && apart; other = next[other]) {
        const glm::dvec3 d = out[other].position - sample.position;
        apart = glm::dot(d, d) >= here * here;
      }
    }
    if (!apart) continue;
    next.push_back(head[bucket(at)]);
    head[bucket(at)] = static_cast<std::uint32_t>(out.size());
    out.push_back(sample);
  }
  return out;
}

SampledSurface scanned(const SampledSurface& surface, int cameras, double pixel, Random& random,
                       const CameraErrors& errors) {
  SampledSurface out;
  const double begin = random.uniform();
  for (int camera = 0; camera < cameras; ++camera) {
    const double a = 2.0 * kPi * (begin + (camera + 0.3 * random.uniform()) / cameras);
    const glm::dvec3 to_camera =
        glm::normalize(glm::dvec3(cosine(a), 0.6 * (random.uniform() - 0.4), sine(a)));
    glm::dvec3 u, v;
    tangents(to_camera, u, v);
    constexpr int kSide = 1 << 11;
    std::vector<std::uint32_t> nearest(std::size_t{kSide} * kSide, ~0u);
    for (std::uint32_t i = 0; i < surface.size(); ++i) {
      if (glm::dot(surface[i].normal, to_camera) < 0.15) continue;
      const auto x = static_cast<int>(std::floor(glm::dot(surface[i].position, u) / pixel));
      const auto y = static_cast<int>(std::floor(glm::dot(surface[i].position, v) / pixel));
      std::uint32_t& best =
          nearest[static_cast<std::size_t>((x & (kSide - 1)) * kSide + (y & (kSide - 1)))];
      if (best == ~0u ||
          glm::dot(surface[i].position, to_camera) > glm::dot(surface[best].position, to_camera)) {
        best = i;
      }
    }
    if (errors.shift == 0.0) {
      for (const std::uint32_t i : nearest) {
        if (i != ~0u) out.push_back({surface[i].position, to_camera});
      }
      continue;
    }
    const double x = random.normal(), y = random.normal(), z = random.normal();
    const glm::dvec3 shift = errors.shift * glm::dvec3(x, y, z);
    const std::uint64_t bend_seed = random.bits();
    for (std::size_t at = 0; at < nearest.size(); ++at) {
      const std::uint32_t i = nearest[at];
      if (i == ~0u) continue;
      glm::dvec3 position = surface[i].position;
      double depth = glm::dot(position, to_camera);
      const std::uint32_t beside = nearest[(at + 1) % nearest.size()];
      const double gap =
          beside == ~0u ? 0.1 : depth - glm::dot(surface[beside].position, to_camera);
      const double before = depth;
      if (gap > 0.01 && random.uniform() < errors.flying) depth -= gap * random.uniform();
      if (errors.step > 0.0) depth = errors.step * std::floor(depth / errors.step + 0.5);
      depth += errors.bend * lattice_noise(position * 6.0, bend_seed);
      position += (depth - before) * to_camera + shift;
      out.push_back({position, to_camera});
    }
  }
  return out;
}

void disturb(SampledSurface& surface, double noise, double outliers, Random& random) {
  for (Sample& sample : surface) {
    const double scale = random.uniform() < 0.1 ? 3.0 * noise : noise;
    sample.position += scale * random.normal() * sample.normal;
    if (random.uniform() >= outliers) continue;
    const double x = random.normal(), y = random.normal(), z = random.normal();
    sample.position += 0.02 * glm::dvec3(x, y, z);
  }
}

}  // namespace pointreel::bench
