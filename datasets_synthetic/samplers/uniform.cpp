#include "datasets_synthetic/samplers/uniform.h"

#include <algorithm>
#include <cmath>
#include <span>

#include <tbb/parallel_for.h>

#include "datasets_synthetic/random.h"
#include "datasets_synthetic/surface_grid.h"

// Points uniform by volume in the shell |distance| <= kShell, moved to the surface along the
// gradient, are uniform by area: over a patch dA the shell holds the volume 2 kShell dA (1 +
// kShell^2 K / 3). K is the Gaussian curvature: 0 on cylinders, a deviation of 1 % on balls of
// 14 mm and of 3 % on fingertips. Where the gradient is shorter than 1, in fillets, the shell is
// thicker in proportion, and a point is kept with the probability that makes up for it. Uniform
// points in the shell come from the cells of a grid that meet it.

namespace pointreel {
namespace {

constexpr double kCell = SurfaceGrid::kCell;
constexpr double kShell = SurfaceGrid::kShell;
constexpr std::size_t kBlock = 2048;  // draws that one task makes

/// One draw; true if it gave a point.
bool draw(const SurfaceGrid& grid, Random random, SurfacePoint& point) {
  const Surface& surface = grid.surface();
  const SurfaceGrid::Cell& cell =
      grid.cells()[random.below(static_cast<std::uint32_t>(grid.cells().size()))];
  const std::span<const std::uint16_t> blends = grid.blends(cell);
  const double x = random.uniform(), y = random.uniform(), z = random.uniform();
  const double keep = random.uniform();
  glm::dvec3 p = cell.min + kCell * glm::dvec3(x, y, z);
  const glm::dvec3 off = p - (cell.min + 0.5 * kCell);
  const double apart = std::abs(cell.distance) - kShell;
  if (apart > 0.0 && glm::dot(off, off) < apart * apart) return false;  // saves the evaluation
  SurfaceDistance at = distance_to(surface, blends, p);
  if (std::abs(at.distance.value) > kShell) return false;
  if (keep >= std::sqrt(glm::dot(at.distance.gradient, at.distance.gradient))) {
    return false;
  }
  for (int step = 0; step < 8; ++step) {
    const glm::dvec3& gradient = at.distance.gradient;
    const double square = glm::dot(gradient, gradient);
    if (square < 1e-4) return false;  // the bottom of a crease: no direction to go
    if (std::abs(at.distance.value) <= 0.01 * kSurfaceTolerance) {
      point = {p, gradient / std::sqrt(square), at.primitive};
      return true;
    }
    p -= at.distance.value / square * gradient;
    at = distance_to(surface, blends, p);
  }
  return false;
}

}  // namespace

Result<std::vector<SurfacePoint>> sample_uniform(const Surface& surface, std::size_t count,
                                                 std::uint64_t seed) {
  const auto grid = SurfaceGrid::build(surface);
  if (!grid) return tl::unexpected(grid.error());
  if (grid->cells().empty()) return fail("cannot sample a surface that has no area");

  // Blocks of draws, in order; how many are made at a time does not change the result.
  std::vector<SurfacePoint> points;
  points.reserve(count + kBlock);
  std::size_t block_begin = 0;
  double yield = 0.2;  // share of draws that give a point
  while (points.size() < count) {
    const double missing = static_cast<double>(count - points.size());
    const std::size_t blocks =
        static_cast<std::size_t>(missing / (yield * static_cast<double>(kBlock)) * 1.02) + 1;
    std::vector<std::vector<SurfacePoint>> found(blocks);
    tbb::parallel_for(std::size_t{0}, blocks, [&](std::size_t block) {
      for (std::size_t i = 0; i < kBlock; ++i) {
        SurfacePoint point;
        const std::uint64_t number = (block_begin + block) * kBlock + i;
        if (draw(*grid, Random(seed, number), point)) found[block].push_back(point);
      }
    });
    std::size_t made = 0;
    for (const auto& some : found) {
      made += some.size();
      points.insert(points.end(), some.begin(), some.end());
    }
    block_begin += blocks;
    yield = static_cast<double>(made) / static_cast<double>(blocks * kBlock);
    if (made == 0) return fail("cannot sample a surface that has almost no area");
  }
  points.resize(count);
  return points;
}

}  // namespace pointreel
