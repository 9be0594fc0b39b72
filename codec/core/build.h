#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <glm/glm.hpp>
#include <glm/gtc/type_precision.hpp>

#include "codec/core/radix_sort.h"
#include "pointreel/cloud.h"
#include "pointreel/error.h"
#include "pointreel/executor.h"
#include "pointreel/octree.h"

namespace pointreel {

// The threads of an executor share the work on large clouds. What is built does not depend on it.

/// The points of a cloud, sorted into the cells of a cube. Choosing the depth, building the tree
/// and averaging the attributes all start from this.
struct SortedPoints {
  Cube cube;
  int levels = kMaxDepth;        ///< the level of the keys
  std::vector<KeyIndex> points;  ///< by Morton key, with the index into the cloud
  /// The number of occupied cells at each level from 0 to `levels`; oct(h) in FORMULAS.md, "Depth
  /// from delta".
  std::vector<std::uint32_t> occupied;
};

/// Quantises and sorts the points, of which there are fewer than 2^31. Points outside the cube move
/// to the cells at its boundary (FORMULAS.md, "Cube of a frame"). Fewer levels take less time.
/// O(n).
SortedPoints sort_points(const PointCloud& cloud, const Cube& cube, int levels = kMaxDepth,
                         const Executor& executor = {});

/// The depth that the rule asks for, at most rule.most. For a delta that is the smallest h, from
/// rule.least on, with oct(h) / n >= 1 - delta, at most the level that tells all distinct points
/// apart (FORMULAS.md, "Depth from delta").
///
/// `occupied`: as in SortedPoints, for the levels that are known. `n`: the number of points that
/// the delta refers to. Error: `argument` if the delta is negative or NaN, or a depth is out of
/// range.
Result<int> choose_depth(std::span<const std::uint32_t> occupied, std::uint64_t n,
                         const DepthRule& rule);

/// Points sorted to at least the depth that a rule asks for.
struct SortedToDepth {
  SortedPoints sorted;
  int depth = 0;
};

/// sort_points and choose_depth in one, with the delta referring to the cloud's distinct points:
/// points no farther apart than half a cell of the deepest level count as one, since that is what
/// repeated vertices are after a rounding. Sorts no more levels than it takes to decide. Errors: as
/// choose_depth.
Result<SortedToDepth> sort_to_depth(const PointCloud& cloud, const Cube& cube,
                                    const DepthRule& rule, const Executor& executor = {});

/// The rule for coding a frame of this many points. Few points are divided further than delta asks,
/// because each stands for itself: to keep them apart says little about where they are
/// (FORMULAS.md, "Depth from delta").
DepthRule coding_rule(DepthRule rule, std::size_t points);

/// Builds the tree of the given depth, 0 to sorted.levels. An empty cloud gives an empty tree.
Svo build_svo(const SortedPoints& sorted, int depth, const Executor& executor = {});

/// Fills in `level_begin` and `first_child` of a tree whose `depth` and `masks` are set. Returns
/// false if the masks do not form such a tree: if an internal node has no child, or there are too
/// few or too many masks. Without masks, the tree is a single cell if `depth` is 0 and `occupied`,
/// otherwise it is empty.
bool index_svo(Svo& svo, bool occupied);

/// The mean attributes of the leaves, from the points in each, and of the inner nodes, from their
/// leaves, each of which counts once. The sums are integers, so the result does not depend on the
/// order of the points.
NodeAttributes mean_attributes(const Svo& svo, const PointCloud& cloud, const SortedPoints& sorted,
                               const Executor& executor = {});

/// One of the two attributes alone. The cloud has it.
std::vector<glm::u16vec3> mean_colors(const Svo& svo, const PointCloud& cloud,
                                      const SortedPoints& sorted, const Executor& executor = {});
std::vector<glm::i16vec3> mean_normals(const Svo& svo, const PointCloud& cloud,
                                       const SortedPoints& sorted, const Executor& executor = {});
/// The same for the leaves alone, in their order.
std::vector<glm::u16vec3> mean_leaf_colors(const Svo& svo, const PointCloud& cloud,
                                           const SortedPoints& sorted,
                                           const Executor& executor = {});
std::vector<glm::i16vec3> mean_leaf_normals(const Svo& svo, const PointCloud& cloud,
                                            const SortedPoints& sorted,
                                            const Executor& executor = {});

/// mean_attributes of a cloud that holds exactly one point for each leaf, in the order of the
/// leaves.
NodeAttributes mean_attributes(const Svo& svo, const PointCloud& leaves,
                               const Executor& executor = {});

}  // namespace pointreel
