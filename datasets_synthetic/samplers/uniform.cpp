#include "datasets_synthetic/samplers/uniform.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <utility>

#include <tbb/parallel_for.h>

#include "datasets_synthetic/random.h"

// Points uniform by volume in the shell |distance| <= kShell, moved to the surface along the
// gradient, are uniform by area: over a patch dA the shell holds the volume 2 kShell dA (1 +
// kShell^2 K / 3). K is the Gaussian curvature: 0 on cylinders, a deviation of 1 % on balls of
// 14 mm and of 3 % on fingertips. Where the gradient is shorter than 1, in fillets, the shell is
// thicker in proportion, and a point is kept with the probability that makes up for it. Uniform
// points in the shell come from the cells of a grid that meet it.

namespace pointreel {
namespace {

constexpr double kCell = 0.011;  // about the fastest for 90,000 points on a person
constexpr double kShell = 0.0025;
constexpr std::size_t kBlock = 2048;  // draws that one task makes

/// A cell and the blends of the surface that matter in it.
struct Cell {
  glm::dvec3 min;
  double distance;  // of the centre
  std::uint32_t first_blend, blend_count;
};

struct Grid {
  std::vector<Cell> cells;  // all of edge kCell
  std::vector<std::uint16_t> blends;
};

/// Divides cubes as an octree does. The distance changes by no more than the way moved, so a cube
/// whose centre is further from the shell than its corners are from the centre cannot meet it.
class GridBuilder {
 public:
  explicit GridBuilder(const Surface& surface) : surface_(surface) {}

  Grid build(const Box& box, int levels) {
    std::vector<std::uint16_t> all(surface_.blends.size());
    for (std::size_t i = 0; i < all.size(); ++i) all[i] = static_cast<std::uint16_t>(i);
    divide(box.min, levels, all);
    return std::move(grid_);
  }

 private:
  void divide(const glm::dvec3& min, int level, std::span<const std::uint16_t> candidates) {
    const double edge = kCell * static_cast<double>(1u << level);
    const double reach = 0.5 * std::sqrt(3.0) * edge + kShell;
    std::vector<double> values(candidates.size());
    const double nearest = blend_distances(surface_, candidates, min + 0.5 * edge, values);
    if (std::abs(nearest) > reach) return;
    // A blend that is nowhere within reach the nearest one has no say in the distance. A point on
    // its way to the surface may leave the cell by kShell.
    std::vector<std::uint16_t> kept;
    for (std::size_t i = 0; i < candidates.size(); ++i) {
      if (values[i] <= reach + kShell && values[i] - nearest <= 2.0 * (reach + kShell)) {
        kept.push_back(candidates[i]);
      }
    }
    if (level == 0) {
      grid_.cells.push_back({min, nearest, static_cast<std::uint32_t>(grid_.blends.size()),
                             static_cast<std::uint32_t>(kept.size())});
      grid_.blends.insert(grid_.blends.end(), kept.begin(), kept.end());
      return;
    }
    for (unsigned child = 0; child < 8; ++child) {
      const glm::dvec3 step(child & 1u, (child >> 1) & 1u, (child >> 2) & 1u);
      divide(min + 0.5 * edge * step, level - 1, kept);
    }
  }

  const Surface& surface_;
  Grid grid_;
};

/// One draw; true if it gave a point.
bool draw(const Surface& surface, const Grid& grid, Random random, SurfacePoint& point) {
  const Cell& cell = grid.cells[random.below(static_cast<std::uint32_t>(grid.cells.size()))];
  const std::span<const std::uint16_t> blends(grid.blends.data() + cell.first_blend,
                                              cell.blend_count);
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
  constexpr int kMaxLevels = 10;  // 11 m
  if (surface.blends.empty()) return fail("cannot sample a surface without any parts");
  Box box = bounds(surface);
  const glm::dvec3 extent = box.extent() + 4.0 * kShell;
  const double largest = std::max({extent.x, extent.y, extent.z});
  if (!(largest <= kCell * static_cast<double>(1 << kMaxLevels))) {
    return fail("cannot sample a surface larger than 11 m");
  }
  box.min -= 2.0 * kShell;
  int levels = 0;
  while (kCell * static_cast<double>(1 << levels) < largest) ++levels;
  const Grid grid = GridBuilder(surface).build(box, levels);
  if (grid.cells.empty()) return fail("cannot sample a surface that has no area");

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
        if (draw(surface, grid, Random(seed, number), point)) found[block].push_back(point);
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
