#include "tests/bench/training/figures.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "common/base/try.h"
#include "datasets_synthetic/body.h"
#include "datasets_synthetic/motion.h"
#include "datasets_synthetic/samplers/uniform.h"
#include "datasets_synthetic/trigonometry.h"

namespace pointreel::bench {

Result<SampledSurface> figure(std::size_t count, Random& random) {
  const std::span<const Motion> all = motions();
  const Motion& motion = all[random.below(static_cast<std::uint32_t>(all.size()))];
  const Body body = pose_body(motion.pose(motion.seconds() * random.uniform()));
  const auto points = TRY(sample_uniform(body.surface, count, random.bits()));
  const glm::dmat3 turn = random_turn(random, true);
  SampledSurface surface;
  surface.reserve(points.size());
  for (const SurfacePoint& point : points) {
    surface.push_back({turn * point.position / 1.76, turn * point.normal});
  }
  return surface;
}

SampledSurface faceted_figure(std::size_t count, Random& random) {
  const auto jitter = [&](double size) {
    const double x = random.normal(), y = random.normal(), z = random.normal();
    return size * glm::dvec3(x, y, z);
  };
  struct Bone {
    glm::dvec3 from, to;
    double radius;
  };
  const glm::dvec3 hip(0.0, 0.52, 0.0), neck(0.0, 0.83, 0.0);
  std::vector<Bone> bones = {{hip, neck, 0.09}, {neck, neck + glm::dvec3(0, 0.15, 0), 0.06}};
  for (const double side : {-1.0, 1.0}) {
    const glm::dvec3 elbow = glm::dvec3(side * 0.25, 0.66, 0) + jitter(0.05);
    const glm::dvec3 hand = elbow + glm::dvec3(side * 0.06, -0.15, 0.05) + jitter(0.05);
    const glm::dvec3 knee = glm::dvec3(side * 0.1, 0.27, 0.02) + jitter(0.03);
    const glm::dvec3 foot = knee + glm::dvec3(0, -0.25, -0.02) + jitter(0.03);
    bones.insert(bones.end(), {{neck + glm::dvec3(side * 0.1, -0.03, 0), elbow, 0.04},
                               {elbow, hand, 0.03},
                               {hip + glm::dvec3(side * 0.06, 0, 0), knee, 0.06},
                               {knee, foot, 0.045},
                               {foot, foot + glm::dvec3(0, -0.02, 0.12), 0.035}});
  }
  std::vector<std::array<glm::dvec3, 3>> faces;
  std::vector<double> area_up_to;
  double area = 0.0;
  const auto add = [&](const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c) {
    area += 0.5 * glm::length(glm::cross(b - a, c - a));
    faces.push_back({a, b, c});
    area_up_to.push_back(area);
  };
  for (const Bone& bone : bones) {
    const auto sides = 5 + random.below(4);
    glm::dvec3 u, v;
    const glm::dvec3 axis = bone.to - bone.from;
    tangents(glm::normalize(axis), u, v);
    constexpr int kRings = 4;
    std::vector<glm::dvec3> ring, last;
    for (int r = 0; r <= kRings; ++r, last = std::move(ring), ring.clear()) {
      const double radius =
          bone.radius * (r == 0 || r == kRings ? 0.5 : 0.8 + 0.4 * random.uniform());
      const glm::dvec3 center = bone.from + axis * (double(r) / kRings);
      for (std::uint32_t s = 0; s < sides; ++s) {
        const double angle = 2.0 * kPi * s / sides;
        ring.push_back(center + radius * (cosine(angle) * u + sine(angle) * v) + jitter(0.003));
      }
      for (std::uint32_t s = 0; s < sides; ++s) {
        const std::uint32_t next = (s + 1) % sides;
        if (r == 0 || r == kRings) add(center, ring[s], ring[next]);
        if (r == 0) continue;
        add(last[s], last[next], ring[s]);
        add(ring[s], last[next], ring[next]);
      }
    }
  }
  const glm::dmat3 turn = random_turn(random, true);
  SampledSurface surface;
  for (std::size_t i = 0; i < count; ++i) {
    const auto face =
        std::lower_bound(area_up_to.begin(), area_up_to.end(), area * random.uniform());
    const auto& [p, q, r] = faces[std::min<std::size_t>(
        static_cast<std::size_t>(face - area_up_to.begin()), faces.size() - 1)];
    double s = random.uniform(), t = random.uniform();
    if (s + t > 1.0) {
      s = 1.0 - s;
      t = 1.0 - t;
    }
    const glm::dvec3 normal = glm::cross(q - p, r - p);
    surface.push_back({turn * (p + s * (q - p) + t * (r - p)),
                       turn * (normal / std::max(glm::length(normal), 1e-12))});
  }
  return surface;
}

}  // namespace pointreel::bench
