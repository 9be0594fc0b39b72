#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "codec/core/build.h"
#include "codec/core/morton.h"
#include "codec/core/radix_sort.h"
#include "pointreel/octree.h"

namespace pointreel {

/// The octree of the given cells at level `depth`. The cells may be in any order.
inline Svo tree_of_cells(const std::vector<glm::uvec3>& cells, int depth) {
  SortedPoints sorted;
  sorted.levels = depth;
  for (std::uint32_t i = 0; i < cells.size(); ++i) {
    sorted.points.push_back({morton_encode(cells[i]), i});
  }
  std::sort(sorted.points.begin(), sorted.points.end(),
            [](const KeyIndex& a, const KeyIndex& b) { return a.key < b.key; });
  return build_svo(sorted, depth);
}

}  // namespace pointreel
