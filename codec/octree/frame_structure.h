#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "pointreel/octree.h"

/// What colours and normals of a frame need to know about its tree. It is found once for both.
namespace pointreel {

/// A node with two children or more. Only these have coefficients.
struct BranchingNode {
  std::uint32_t number, first_child;
  std::uint32_t place;  ///< in the plane of its slice
  std::uint32_t mask;
};

/// The nodes of a level slice by slice: by z, and in Morton order where z is equal.
struct NodesByZ {
  struct Slice {
    std::uint32_t z;
    std::uint32_t begin, branching_begin;
  };
  /// The slices that have any nodes, which go from one slice's `begin` to that of the next. One
  /// more stands at the end.
  std::span<const Slice> slices;
  /// A node, and where it is: x and y from 16 bits on, from where the level's parents begin.
  std::span<const std::uint32_t> nodes, at;
  std::span<const BranchingNode> branching;
};

struct LevelStructure {
  /// The nodes with two children or more in Morton order, in which they are coded.
  std::span<const std::uint32_t> branching;
  /// Of a predictable level whose order was asked for, otherwise empty.
  NodesByZ by_z;
  /// A plane holds a cell for each x and y of the level's nodes, with a margin of one. Its row and
  /// its whole size.
  std::uint32_t stride = 0;
  std::size_t plane = 0;
  /// The least x and y of NodesByZ::at.
  std::uint32_t least_x = 0, least_y = 0;
  /// The children of a level's nodes may be predicted unless its planes are far larger than the
  /// level. This bounds the memory of a decoder. FORMAT.md, "Prediction".
  bool predictable = false;

  /// The place in the plane of its slice of what is `at` some x and y.
  std::uint32_t place(std::uint32_t at) const {
    return ((at >> 16) - least_y + 1) * stride + (at & 0xffff) - least_x + 1;
  }
};

/// A set of levels, one bit for each.
using LevelSet = std::uint32_t;
inline constexpr LevelSet kAllLevels = ~LevelSet{0};

/// Takes at most 44 bytes for each inner node of the tree.
class FrameStructure {
 public:
  /// `layer_ends`: the last level of each layer; the last one is svo.depth. `ordered`: the levels
  /// whose nodes are needed by z. No level below the last of them is predictable. The tree must
  /// outlive the structure.
  FrameStructure(const Svo& svo, std::vector<int> layer_ends, LevelSet ordered = kAllLevels);

  const Svo& svo() const { return svo_; }
  const std::vector<int>& layer_ends() const { return layer_ends_; }

  /// Levels are less than svo.depth.
  const LevelStructure& level(int level) const { return levels_[static_cast<std::size_t>(level)]; }

  /// True if the children of a level's nodes are at the last level of a layer, where all of them
  /// weigh 1.
  bool has_unit_children(int level) const;
  /// The weights of nodes above the last level of a layer, by node: how many descendants they have
  /// at that level, at most 2^26.
  const std::uint32_t* weights() const { return weights_.get(); }

  /// The number of cells in the planes of the largest level whose children may be predicted.
  std::size_t largest_plane() const { return largest_plane_; }

 private:
  void find_weights();
  void find_branching();
  void order_by_z(LevelSet ordered);
  void descend(int level);
  void find_plane(int level);
  void list_branching(int level);

  const Svo& svo_;
  std::vector<int> layer_ends_;
  std::vector<LevelStructure> levels_;
  std::vector<std::vector<NodesByZ::Slice>> slices_;
  std::vector<std::unique_ptr<BranchingNode[]>> branching_by_z_;
  using Numbers = std::unique_ptr<std::uint32_t[]>;
  Numbers weights_, branching_, nodes_, at_;
  std::size_t largest_plane_ = 0;
};

}  // namespace pointreel
