#pragma once

#include <vector>

#include <glm/glm.hpp>

#include "pointreel/codec.h"
#include "pointreel/octree.h"

namespace pointreel::golden {

/// The cells of an octree's leaves, or those in whose centres Draco's points are.
inline std::vector<glm::uvec3> cells_of(const DecodedFrame& frame, int depth) {
  if (frame.svo) return leaf_cells(*frame.svo);
  std::vector<glm::uvec3> cells;
  const double scale = static_cast<double>(1 << depth) / frame.cube.edge;
  for (const glm::vec3& p : frame.cloud.positions) cells.emplace_back(glm::dvec3(p) * scale);
  return cells;
}

}  // namespace pointreel::golden
