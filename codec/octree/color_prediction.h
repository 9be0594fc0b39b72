#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "codec/octree/int4.h"
#include "common/octree/svo.h"

/// Predicts the colours of children from those of their parent and of the parent's neighbours, as
/// far as they touch the child. FORMAT.md, "Prediction".
namespace pointreel {

/// The fourth lane of a node's value: 1 for being there, and how much there was to code around it.
inline constexpr std::int32_t kActivityUnit = 256;
inline constexpr std::int32_t kMostActivity = 127;

/// The values around the eight octants of one node: cells of the level below it, 4 along an axis, x
/// fastest, of which the middle 2 x 2 x 2 are its own. Where no node is, all lanes are 0.
struct ValueBlock {
  std::array<Short4, 64> values{};

  /// The octant's cell.
  static int cell(int octant) { return 21 + (octant & 1) + (octant & 2) * 2 + (octant & 4) * 4; }

  /// What child `octant` of the node in `cell` is expected to be: the mean of that node, weighing
  /// 18, of its neighbours across the child's three outer faces, 8 each, and across its three outer
  /// edges, 3 each. |value| is no larger than the largest of them. Adds the weights and what they
  /// make of the activities to `weight` and `activity`.
  Int4 predict(int cell, int octant, std::int32_t& weight, std::int32_t& activity) const;
};

/// The neighbours of the nodes of one level, found level by level from the root down without any
/// search. Memory: 108 bytes for each node of the level.
class Neighborhoods {
 public:
  explicit Neighborhoods(const Svo& svo);

  int level() const { return level_; }
  /// To the next level; the current one is at most svo.depth - 1.
  void descend();

  /// Loads the values of the cells around node `node` of the current level; `values` are those of
  /// all nodes of the tree, of which the level's children are used.
  void load(std::uint32_t node, const std::vector<Short4>& values, ValueBlock& block) const;

 private:
  /// 3 x 3 x 3 nodes, x fastest, the corners unused.
  using Block = std::array<std::uint32_t, 27>;

  const Svo* svo_;
  int level_ = 0;
  std::vector<Block> blocks_;
};

}  // namespace pointreel
