#include "tests/bench/surface/true_surface.h"

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <glm/glm.hpp>
#include <tbb/parallel_for.h>

#include "codec/distance/nearest.h"

namespace pointreel::bench {
namespace {

/// The distance function is a lower bound near fillets, so that it takes more than one step.
constexpr int kSteps = 10;

struct Foot {
  glm::dvec3 place;
  glm::dvec3 normal;
  std::uint16_t primitive;
};

Foot foot_of(const Surface& surface, glm::dvec3 place) {
  for (int step = 0; step < kSteps; ++step) {
    const Distance distance = distance_to(surface, place).distance;
    place -= distance.value * glm::normalize(distance.gradient);
  }
  const SurfaceDistance at = distance_to(surface, place);
  return {place, glm::normalize(at.distance.gradient), at.primitive};
}

/// Surfels as seen from the true surface.
struct Heights {
  std::vector<glm::dvec3> feet;
  std::vector<double> above;
};

Heights heights_of(const Surface& surface, const PointCloud& cloud) {
  Heights out{std::vector<glm::dvec3>(cloud.size()), std::vector<double>(cloud.size())};
  tbb::parallel_for(std::size_t{0}, cloud.size(), [&](std::size_t i) {
    const Foot foot = foot_of(surface, cloud.world(i));
    out.feet[i] = foot.place;
    out.above[i] = glm::dot(cloud.world(i) - foot.place, foot.normal);
  });
  return out;
}

}  // namespace

PointCloud onto_true_surface(const Body& truth, const PointCloud& cloud) {
  PointCloud out = cloud;
  out.normals.resize(cloud.size());
  tbb::parallel_for(std::size_t{0}, cloud.size(), [&](std::size_t i) {
    const Foot foot = foot_of(truth.surface, cloud.world(i));
    out.positions[i] = glm::vec3(foot.place - cloud.origin);
    out.normals[i] = glm::vec3(foot.normal);
    if (cloud.has_colors())
      out.colors[i] =
          std::uint16_t{257} * glm::u16vec3(color_at(truth, foot.primitive, foot.place));
  });
  return out;
}

double movement_of_surface(const Body& truth, const PointCloud& before, const PointCloud& after) {
  const Heights first = heights_of(truth.surface, before);
  const Heights second = heights_of(truth.surface, after);
  const NearestPoints nearest = nearest_points(first.feet, second.feet, 0.0);
  double squares = 0.0;
  for (std::size_t i = 0; i < first.feet.size(); ++i) {
    const double moved = second.above[nearest.of(i).front()] - first.above[i];
    squares += moved * moved;
  }
  return std::sqrt(squares / static_cast<double>(first.feet.size()));
}

}  // namespace pointreel::bench
