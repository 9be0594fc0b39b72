#include "tests/bench/render/sampling_limit.h"

#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <tbb/parallel_for.h>

#include "client/render/view.h"

namespace pointreel::bench {
namespace {

constexpr double kSigma = 0.4, kReach = 2.2;  // in units of the spacing
constexpr int kStep = 3;

/// The points in a hash table of cells with the edge `reach`.
class Neighbors {
 public:
  Neighbors(const PointCloud& cloud, double reach)
      : cloud_(cloud),
        reach_(reach),
        heads_(std::bit_ceil(2 * cloud.size() + 1), kNone),
        next_(cloud.size(), kNone) {
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      std::uint32_t& head = heads_[slot(cell_of(cloud.world(i)))];
      next_[i] = head;
      head = static_cast<std::uint32_t>(i);
    }
  }

  /// Calls visit(point, squared distance) for each point within the reach of p.
  template <class Visit>
  void around(const glm::dvec3& p, const Visit& visit) const {
    const glm::ivec3 cell = cell_of(p);
    for (int i = 0; i < 27; ++i) {
      const glm::ivec3 at = cell + glm::ivec3(i % 3, i / 3 % 3, i / 9) - 1;
      for (std::uint32_t point = heads_[slot(at)]; point != kNone; point = next_[point]) {
        const glm::dvec3 q = cloud_.world(point);
        if (cell_of(q) != at) continue;  // from another cell with the same slot
        const double square = glm::dot(q - p, q - p);
        if (square < reach_ * reach_) visit(point, square);
      }
    }
  }

 private:
  static constexpr std::uint32_t kNone = ~std::uint32_t{0};

  glm::ivec3 cell_of(const glm::dvec3& p) const { return glm::ivec3(glm::floor(p / reach_)); }
  std::size_t slot(const glm::ivec3& cell) const {
    const std::uint64_t hash = static_cast<std::uint64_t>(cell.x) * 0x9e3779b97f4a7c15u ^
                               static_cast<std::uint64_t>(cell.y) * 0xc2b2ae3d27d4eb4fu ^
                               static_cast<std::uint64_t>(cell.z) * 0x165667b19e3779f9u;
    return (hash ^ hash >> 29) & (heads_.size() - 1);
  }

  const PointCloud& cloud_;
  double reach_;
  std::vector<std::uint32_t> heads_, next_;
};

glm::dvec3 color_of(const PointCloud& cloud, std::size_t point) {
  glm::dvec3 color;
  for (int c = 0; c < 3; ++c) {
    color[c] = linear_from_srgb(cloud.has_colors() ? cloud.colors[point][c] / 65535.0
                                                   : 0.5 + 0.5 * cloud.normals[point][c]);
  }
  return color;
}

}  // namespace

std::optional<double> sampling_limit(const RenderScene& scene, const ViewTruth& view) {
  const PointCloud& cloud = scene.surfels->cloud;
  const Camera& camera = view.view.camera;
  const Image& truth = view.truth.image;
  const glm::ivec2 size(truth.width, truth.height);
  const Neighbors neighbors(cloud, kReach * scene.spacing);
  std::vector<glm::dvec3> colors(cloud.size());
  tbb::parallel_for(std::size_t{0}, cloud.size(), [&](std::size_t i) {
    colors[i] = lit(color_of(cloud, i), glm::dvec3(cloud.normals[i]), camera,
                    light_strength(true, cloud.has_colors()));
  });
  Image best = truth;
  Mask mask(truth.pixels.size(), 0);
  tbb::parallel_for(0, size.y / kStep, [&](int row) {
    const int y = kStep * row;
    for (int x = 0; x < size.x; x += kStep) {
      const auto i = static_cast<std::size_t>(y) * static_cast<std::size_t>(size.x) +
                     static_cast<std::size_t>(x);
      if (!view.truth.mask[i]) continue;
      const auto hit = truth_at(scene.truth, camera, size, {x, y});
      if (!hit) continue;
      glm::dvec3 sum(0.0);
      double weights = 0.0;
      neighbors.around(hit->position, [&](std::size_t point, double square) {
        if (glm::dot(glm::dvec3(cloud.normals[point]), camera.eye() - hit->position) <= 0.0) return;
        const double sigma = kSigma * scene.spacing;
        const double weight = std::exp(-0.5 * square / (sigma * sigma));
        sum += weight * colors[point];
        weights += weight;
      });
      mask[i] = 255;
      if (weights > 0.0) best.pixels[i] = srgb_from_linear(sum / weights);
    }
  });
  return psnr(truth, best, mask);
}

}  // namespace pointreel::bench
