#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <glm/glm.hpp>
#include <glm/gtc/type_precision.hpp>

#include "common/octree/radix_sort.h"
#include "pointreel/cloud.h"
#include "pointreel/error.h"
#include "pointreel/octree.h"

namespace pointreel {

/// The points of a cloud sorted into the cells of a cube: what the choice of depth, the tree and
/// the attributes all start from.
struct SortedPoints {
  Cube cube;
  int levels = kMaxDepth;        ///< the keys are those of this level
  std::vector<KeyIndex> points;  ///< by Morton key; index into the cloud
  /// oct(h) of the paper: occupied cells at level h, for h = 0 to `levels`.
  std::vector<std::uint32_t> occupied;
};

/// Quantises and sorts. Points outside the cube clamp to its boundary cells (ERRATA 12). O(n).
/// The cloud holds fewer than 2^31 points. Fewer levels than kMaxDepth take less time.
SortedPoints sort_points(const PointCloud& cloud, const Cube& cube, int levels = kMaxDepth);

/// The smallest h with oct(h) / n >= 1 - delta, at most the level at which all distinct points are
/// apart (ERRATA 4); or the fixed depth; but never more than rule.most. `occupied` holds oct(h) of
/// every level that there is; `n` is the number of points that the delta refers to: the input
/// points, duplicates included. Refuses a NaN or negative delta and depths out of range.
Result<int> choose_depth(std::span<const std::uint32_t> occupied, std::uint64_t n,
                         const DepthRule& rule);

/// Points sorted to at least the depth that a rule gives them.
struct SortedToDepth {
  SortedPoints sorted;
  int depth = 0;
};

/// sort_points and choose_depth in one, for the cloud's own number of points: sorts no more levels
/// than it takes to decide. Refuses what choose_depth refuses.
Result<SortedToDepth> sort_to_depth(const PointCloud& cloud, const Cube& cube,
                                    const DepthRule& rule);

/// Builds the tree of the given depth (0 to sorted.levels). An empty cloud gives an empty tree.
Svo build_svo(const SortedPoints& sorted, int depth);

/// Mean attributes of the leaves from the points in them, and of the inner nodes from their leaves,
/// each leaf counting once. Integer sums: the result does not depend on the order of the points.
NodeAttributes mean_attributes(const Svo& svo, const PointCloud& cloud, const SortedPoints& sorted);

/// Either of them alone; the cloud has it.
std::vector<glm::u16vec3> mean_colors(const Svo& svo, const PointCloud& cloud,
                                      const SortedPoints& sorted);
std::vector<glm::i16vec3> mean_normals(const Svo& svo, const PointCloud& cloud,
                                       const SortedPoints& sorted);
/// Those of the leaves only, in their order.
std::vector<glm::u16vec3> mean_leaf_colors(const Svo& svo, const PointCloud& cloud,
                                           const SortedPoints& sorted);

std::vector<glm::i16vec3> mean_leaf_normals(const Svo& svo, const PointCloud& cloud,
                                            const SortedPoints& sorted);

/// mean_attributes where the cloud holds exactly one point for each leaf, in the order of the
/// leaves.
NodeAttributes mean_attributes(const Svo& svo, const PointCloud& leaves);

}  // namespace pointreel
