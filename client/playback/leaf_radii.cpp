#include "client/playback/leaf_radii.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace pointreel {
namespace {

/// Four on a closed surface; random samples of one fall below this where a cell holds about one.
constexpr double kClosedGrowth = 2.8;
constexpr double kCellsPerFace = 1.5;
constexpr int kBlockLevels = 2;

/// The finest level at which the tree still looks like a closed surface; the leaves' if none does.
int closed_level(const Svo& svo) {
  for (int level = svo.depth; level > 0; --level) {
    if (svo.node_count(level) >= kClosedGrowth * svo.node_count(level - 1)) return level;
  }
  return svo.depth;
}

/// How many nodes of `level` lie before the first descendant of a node at `from`.
std::uint32_t first_descendant(const Svo& svo, std::uint32_t node, int from, int level) {
  for (int l = from; l < level; ++l) node = svo.first_child[node];
  return node - svo.level_begin[static_cast<std::size_t>(level)];
}

}  // namespace

std::vector<float> leaf_radii(const Svo& svo) {
  const double leaf = svo.cell_size(svo.depth);
  const double least = 0.5 * std::sqrt(3.0) * leaf;
  std::vector<float> radii(svo.leaf_count(), static_cast<float>(least));
  if (radii.empty()) return radii;

  const int closed = closed_level(svo);
  const int block_level = std::max(0, closed - kBlockLevels);
  const double cell = svo.cell_size(closed);
  const std::uint32_t first = svo.level_begin[static_cast<std::size_t>(block_level)];
  const std::uint32_t blocks = svo.node_count(block_level);
  std::uint32_t cell_begin = 0, leaf_begin = 0;
  for (std::uint32_t block = 0; block < blocks; ++block) {
    const bool last = block + 1 == blocks;
    const std::uint32_t next = first + block + 1;
    const std::uint32_t cell_end =
        last ? svo.node_count(closed) : first_descendant(svo, next, block_level, closed);
    const std::uint32_t leaf_end =
        last ? svo.leaf_count() : first_descendant(svo, next, block_level, svo.depth);
    const double area = cell * cell * (cell_end - cell_begin) / kCellsPerFace;
    const double radius = std::max(least, std::sqrt(area / (leaf_end - leaf_begin)));
    std::fill(radii.begin() + leaf_begin, radii.begin() + leaf_end, static_cast<float>(radius));
    cell_begin = cell_end;
    leaf_begin = leaf_end;
  }
  return radii;
}

}  // namespace pointreel
