#pragma once

#include <cstdint>
#include <vector>

#include <glm/glm.hpp>
#include <glm/gtc/type_precision.hpp>

#include "pointreel/cloud.h"
#include "pointreel/geometry.h"

namespace pointreel {

/// The finest level of an octree: 21 bits for each axis, so that a Morton key fits into 63 bits.
inline constexpr int kMaxDepth = 21;

/// A sparse voxel octree (Slomp et al., Geometry Instancing, section VI). Level 0 is the root, and
/// all leaves are at level `depth`. Nodes are numbered breadth-first, each level in Morton order,
/// so that `masks`, one byte for each internal node, describes the whole tree (FORMULAS.md,
/// "Breadth-first stream"). `first_child` gives random access to it ("Child index").
struct Svo {
  Cube cube;
  int depth = 0;
  /// depth + 2 entries: the nodes of level l are [level_begin[l], level_begin[l + 1]). An empty
  /// tree has no nodes on any level.
  std::vector<std::uint32_t> level_begin = {0, 0};
  /// Bit c of masks[i] is set if internal node i has child c (in Morton order, x lowest).
  std::vector<std::uint8_t> masks;
  /// The children of internal node i are consecutive nodes, in the order of the mask's bits, and
  /// begin at first_child[i].
  std::vector<std::uint32_t> first_child;

  std::uint32_t node_count() const { return level_begin.back(); }
  std::uint32_t node_count(int level) const {
    return level_begin[static_cast<std::size_t>(level) + 1] -
           level_begin[static_cast<std::size_t>(level)];
  }
  std::uint32_t leaf_count() const { return node_count(depth); }
  std::uint32_t internal_count() const { return static_cast<std::uint32_t>(masks.size()); }
  /// The edge of a cell, in world units.
  double cell_size(int level) const;
};

/// Mean attributes of every node, in the order of the nodes. An array is empty if the cloud does
/// not have the attribute.
struct NodeAttributes {
  std::vector<glm::u16vec3> colors;   ///< as PointCloud::colors
  std::vector<glm::i16vec3> normals;  ///< unit vectors times 32767, or zero where unknown
};

/// How deep to divide: either to a fixed depth, or until few enough points share a cell.
struct DepthRule {
  enum class Kind { delta, fixed };
  Kind kind = Kind::delta;
  /// With Kind::delta, the share of distinct points that may be lost because they fall into the
  /// same cell as another. FORMULAS.md, "Depth from delta".
  double delta = 0.05;
  int depth = 10;        ///< with Kind::fixed, 0 to kMaxDepth
  int most = kMaxDepth;  ///< an upper bound on the depth in both cases, 0 to kMaxDepth
  int least = 0;         ///< a lower bound with Kind::delta, unless `most` is less

  static DepthRule by_delta(double delta) { return {Kind::delta, delta, 0}; }
  static DepthRule fixed(int depth) { return {Kind::fixed, 0.0, depth}; }
};

/// The same tree cut off at level `depth`; unchanged if it is no deeper than that.
Svo truncate(const Svo& svo, int depth);

/// The integer coordinates of the leaves' cells at level `svo.depth`, in the order of the leaves.
std::vector<glm::uvec3> leaf_cells(const Svo& svo);

/// The centres of the leaves in their order, as a cloud whose origin is the cube's.
PointCloud leaf_centers(const Svo& svo);

}  // namespace pointreel
