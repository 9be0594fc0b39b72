#include "codec/package/max_error.h"

#include <algorithm>
#include <cmath>

#include "pointreel/octree.h"

namespace pointreel {

namespace {

/// How far rounding may move a decoded position along an axis.
double rounding(const Cube& cube) {
  double farthest = cube.edge;
  for (int axis = 0; axis < 3; ++axis) {
    const double low = cube.origin[axis];
    farthest = std::max({farthest, std::abs(low), std::abs(low + cube.edge)});
  }
  const double to_float = std::ldexp(cube.edge, -24);
  // A few operations, each off by half a unit in the last place: the difference of two origins, its
  // sum with a position, the product with the number of cells per unit, and the way back.
  const double in_double = std::ldexp(farthest, -50);
  return to_float + in_double;
}

}  // namespace

double max_geometry_error(const Cube& cube, int depth) {
  const double half_cell = std::ldexp(cube.edge, -depth - 1);
  return std::sqrt(3.0) * (half_cell + rounding(cube));
}

double geometry_error(const PointCloud& cloud, const Cube& cube, int depth) {
  const glm::dvec3 corner = cloud.origin - cube.origin;
  const double cells_per_unit = std::ldexp(1.0, kMaxDepth) / cube.edge;
  const double cell = std::ldexp(cube.edge, -depth), last = std::ldexp(1.0, kMaxDepth) - 1.0;
  double most = 0.0;
  for (const glm::vec3& p : cloud.positions) {
    const glm::dvec3 local = glm::dvec3(p) + corner;
    // The cell, as the codecs find it: at level kMaxDepth first.
    const glm::dvec3 finest = glm::clamp(glm::floor(local * cells_per_unit), 0.0, last);
    const glm::dvec3 index = glm::floor(finest * std::ldexp(1.0, depth - kMaxDepth));
    const glm::dvec3 off = glm::dvec3(glm::vec3((index + 0.5) * cell)) - local;
    most = std::max(most, glm::dot(off, off));
  }
  if (most == 0.0) return 0.0;
  const double found = std::sqrt(most), rounded = found + std::sqrt(3.0) * rounding(cube);
  return std::max(found, std::min(rounded, max_geometry_error(cube, depth)));
}

}  // namespace pointreel
