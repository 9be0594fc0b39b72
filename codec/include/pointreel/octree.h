#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <glm/glm.hpp>
#include <glm/gtc/type_precision.hpp>

#include "pointreel/cloud.h"
#include "pointreel/geometry.h"

namespace pointreel {

/// The finest level of an octree: 21 bits an axis, so that a Morton key fits 63 bits.
inline constexpr int kMaxDepth = 21;

/// A sparse voxel octree, paper 2, section VI. All leaves lie at level `depth`; level 0 is the
/// root. Nodes are numbered breadth-first, each level in Morton order, so `masks` alone, one byte
/// for each internal node, is the whole tree (ERRATA 6), and `first_child` is what makes it
/// traversable at random (ERRATA 8).
struct Svo {
  Cube cube;
  int depth = 0;
  /// depth + 2 entries: level l is the nodes [level_begin[l], level_begin[l + 1]). An empty tree
  /// has no nodes on any level.
  std::vector<std::uint32_t> level_begin = {0, 0};
  /// Bit c of masks[i]: internal node i has child c (Morton order, x lowest).
  std::vector<std::uint8_t> masks;
  /// The children of internal node i are consecutive nodes from first_child[i] on, in bit order.
  std::vector<std::uint32_t> first_child;

  std::uint32_t node_count() const { return level_begin.back(); }
  std::uint32_t node_count(int level) const {
    return level_begin[static_cast<std::size_t>(level) + 1] -
           level_begin[static_cast<std::size_t>(level)];
  }
  std::uint32_t leaf_count() const { return node_count(depth); }
  std::uint32_t internal_count() const { return static_cast<std::uint32_t>(masks.size()); }
  double cell_size(int level) const;
};

/// Mean attributes of every node, in the order of the nodes; each array is empty where the cloud
/// has no such attribute. Normals are unit vectors times 32767, or zero where unknown.
struct NodeAttributes {
  std::vector<glm::u16vec3> colors;
  std::vector<glm::i16vec3> normals;
};

/// How deep to divide. Exactly one rule applies.
struct DepthRule {
  enum class Kind { delta, fixed };
  Kind kind = Kind::delta;
  double delta = 0.05;  ///< acceptable share of points lost to merging; 0.05 is the paper's default
  int depth = 10;       ///< 0 to kMaxDepth
  int most = kMaxDepth;  ///< whatever the rule says, no deeper than this; 0 to kMaxDepth

  static DepthRule by_delta(double delta) { return {Kind::delta, delta, 0}; }
  static DepthRule fixed(int depth) { return {Kind::fixed, 0.0, depth}; }
};

/// Makes `level_begin` and `first_child` of a tree whose `depth` and `masks` are set; false if the
/// masks are no such tree (an internal node without a child, too few or too many masks). Without
/// masks the tree is a single cell if `depth` is 0 and `occupied`, otherwise empty.
bool index_svo(Svo& svo, bool occupied);

/// The same tree cut off at a coarser level; depth <= svo.depth.
Svo truncate(const Svo& svo, int depth);

/// Cells of the leaves, in order: local integer coordinates at level `svo.depth`.
std::vector<glm::uvec3> leaf_cells(const Svo& svo);

/// Their centres, in order, relative to the cube's origin.
PointCloud leaf_centers(const Svo& svo);

}  // namespace pointreel
