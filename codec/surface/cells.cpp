#include "codec/surface/cells.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace pointreel {
namespace {

/// Points that share a cell this many levels further down count as one.
constexpr int kDuplicateLevels = 6;

}  // namespace

int choose_level(const SortedPoints& sorted, double points_per_cell, int limit) {
  const double cells = sorted.occupied.back() / points_per_cell;
  int level = 0;
  while (level < limit && sorted.occupied[static_cast<std::size_t>(level) + 1] <= cells) ++level;
  return level;
}

SortedIntoCells sort_into_cells(const PointCloud& cloud, double points_per_cell,
                                const Executor& executor) {
  const Cube tight = bounding_cube(bounds(cloud));
  // Few levels are faster to sort, and usually tell most points apart.
  SortedPoints sorted = sort_points(cloud, tight, 12, executor);
  if (sorted.occupied.back() < cloud.size() / 2)
    sorted = sort_points(cloud, tight, kMaxDepth, executor);
  int level = choose_level(sorted, points_per_cell, sorted.levels - 1);
  // Cells of this level may be up to twice as large as they should be. Enlarging the cube by the
  // right factor gives those of the next level the right size.
  const double per_cell = static_cast<double>(sorted.occupied.back()) /
                          sorted.occupied[static_cast<std::size_t>(level) + 1];
  const double factor = std::clamp(std::sqrt(points_per_cell / per_cell), 1.0, 2.0);
  level = std::min(level + 1, kMaxDepth - 1);
  Cube cube = tight;
  cube.edge *= factor;
  cube.origin -= 0.5 * (cube.edge - tight.edge);
  const int levels = std::min(level + kDuplicateLevels, kMaxDepth);
  return {sort_points(cloud, cube, levels, executor), level};
}

}  // namespace pointreel
