#include "pointreel/geometry.h"

#include <algorithm>
#include <cmath>

namespace pointreel {

Cube bounding_cube(const Box& box) {
  if (box.empty()) return {};
  const glm::dvec3 extent = box.extent();
  const double edge = std::max({extent.x, extent.y, extent.z});
  return {box.min, edge > 0.0 ? edge : 1.0};
}

VoxelCube voxel_cube(const Box& box, double voxel) {
  if (box.empty()) return {{glm::dvec3(-0.5 * voxel), voxel}, 0};
  const glm::dvec3 first = glm::floor(box.min / voxel + 0.5);
  const glm::dvec3 last = glm::floor(box.max / voxel + 0.5);
  const glm::dvec3 cells = last - first + 1.0;
  const double widest = std::max({cells.x, cells.y, cells.z});
  int depth = 0;
  double side = 1.0;
  while (side < widest && depth < 64) {
    side *= 2.0;
    ++depth;
  }
  return {{(first - 0.5) * voxel, side * voxel}, depth};
}

}  // namespace pointreel
