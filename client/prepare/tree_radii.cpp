#include "client/prepare/tree_radii.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "codec/core/build.h"

namespace pointreel {
namespace {

/// How many times more nodes a level has. It is four on a closed surface, and falls below this
/// where a cell holds about one random sample.
constexpr double kClosedGrowth = 2.8;
constexpr double kCellsPerFace = 1.5;
constexpr int kBlockLevels = 2;
/// The most that a radius may exceed the mean of the whole surface: a block with a corner of the
/// surface, or with one stray point, would otherwise get discs that stick out.
constexpr double kMaxRadius = 3.0;
/// The least radius, in edges of a cell of the closed level. Points along curves lie denser than
/// the gaps between the curves are wide, and discs must close these gaps, which are about as wide
/// as the finest cells of which none is empty. Random points have no smaller radius than this
/// anyway.
constexpr double kLeastOfClosedCell = 0.3;

/// Where nothing looks closed, such as along a line or for single points, this many leaves have a
/// cell of their own on the level that stands in. Its cells are small beside the cube: a single
/// point has no spacing, and must not fill the picture.
constexpr double kApart = 0.95;
constexpr int kSmallCells = 5;

/// A level whose occupied cells cover the surface, and the edge of the squares that do so.
struct ClosedLevel {
  int level;
  double edge;
};

/// The level above the finest level that still looks like a closed surface: up to a third of the
/// cells of the finest may be missing already.
ClosedLevel closed_level(const Svo& svo) {
  for (int level = svo.depth; level > 0; --level) {
    if (svo.node_count(level) >= kClosedGrowth * svo.node_count(level - 1))
      return {level - 1, svo.cell_size(level - 1)};
  }
  int level = 0;
  while (level < svo.depth && svo.node_count(level) < kApart * svo.leaf_count()) ++level;
  return {level, svo.cell_size(std::max(level, kSmallCells))};
}

/// How many nodes of `level` come before the first descendant of a node on level `from`.
std::uint32_t first_descendant(const Svo& svo, std::uint32_t node, int from, int level) {
  for (int l = from; l < level; ++l) node = svo.first_child[node];
  return node - svo.level_begin[static_cast<std::size_t>(level)];
}

/// A part of the tree with leaves [begin, end) and the area of the surface in it.
struct Block {
  std::uint32_t begin, end;
  double area;
};

double radius_of(double area, std::size_t points) {
  return std::sqrt(area / static_cast<double>(std::max<std::size_t>(1, points)));
}

/// The largest radius allowed, for `points` on all blocks.
double cap_of(const std::vector<Block>& blocks, std::size_t points) {
  double area = 0.0;
  for (const Block& block : blocks) area += block.area;
  return kMaxRadius * radius_of(area, points);
}

std::vector<Block> measure_blocks(const Svo& svo) {
  const auto [closed, edge] = closed_level(svo);
  const int level = std::max(0, closed - kBlockLevels);
  const double area_of_cell = edge * edge / kCellsPerFace;
  const std::uint32_t count = svo.node_count(level);
  const std::uint32_t first = svo.level_begin[static_cast<std::size_t>(level)];
  std::vector<Block> blocks;
  blocks.reserve(count);
  std::uint32_t cell_begin = 0, leaf_begin = 0;
  for (std::uint32_t i = 1; i <= count; ++i) {
    const bool last = i == count;
    const std::uint32_t cell_end =
        last ? svo.node_count(closed) : first_descendant(svo, first + i, level, closed);
    const std::uint32_t leaf_end =
        last ? svo.leaf_count() : first_descendant(svo, first + i, level, svo.depth);
    blocks.push_back({leaf_begin, leaf_end, area_of_cell * (cell_end - cell_begin)});
    cell_begin = cell_end;
    leaf_begin = leaf_end;
  }
  return blocks;
}

}  // namespace

std::vector<float> leaf_radii(const Svo& svo) {
  const double least = std::max(0.5 * std::sqrt(3.0) * svo.cell_size(svo.depth),
                                kLeastOfClosedCell * closed_level(svo).edge);
  const std::vector<Block> blocks = measure_blocks(svo);
  const double most = std::max(least, cap_of(blocks, svo.leaf_count()));
  std::vector<float> radii(svo.leaf_count());
  for (const Block& block : blocks) {
    const double radius = std::clamp(radius_of(block.area, block.end - block.begin), least, most);
    std::fill(radii.begin() + block.begin, radii.begin() + block.end, static_cast<float>(radius));
  }
  return radii;
}

std::vector<float> point_radii(const Svo& svo, const SortedPoints& sorted) {
  const std::vector<Block> blocks = measure_blocks(svo);
  const double most = sorted.occupied.empty() ? 0.0 : cap_of(blocks, sorted.occupied.back());
  std::vector<float> radii(sorted.points.size());
  const int shift = 3 * (sorted.levels - svo.depth);
  std::size_t begin = 0;
  std::uint32_t leaf = 0;  // the leaf of the point before `end`
  for (const Block& block : blocks) {
    // The block's points are those of its leaves, and points and leaves have the same order.
    std::size_t end = begin;
    std::uint32_t distinct = 0;
    for (; end < sorted.points.size(); ++end) {
      const std::uint64_t key = sorted.points[end].key;
      const std::uint64_t before = end == 0 ? key : sorted.points[end - 1].key;
      const std::uint32_t its_leaf = leaf + (key >> shift != before >> shift ? 1 : 0);
      if (its_leaf >= block.end) break;
      leaf = its_leaf;
      if (end == begin || key != before) ++distinct;
    }
    const auto radius = static_cast<float>(std::min(radius_of(block.area, distinct), most));
    for (std::size_t i = begin; i < end; ++i) radii[sorted.points[i].index] = radius;
    begin = end;
  }
  return radii;
}

}  // namespace pointreel
