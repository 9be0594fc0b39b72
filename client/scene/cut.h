#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <glm/glm.hpp>

#include "client/scene/camera.h"
#include "pointreel/octree.h"

namespace pointreel {

/// An element to draw: a node of the octree at which the traversal stopped.
struct CutNode {
  std::uint32_t node;
  glm::vec3 center;  ///< relative to the cube's origin
  float half;        ///< half its edge
};

struct CutStats {
  std::uint32_t visited = 0;  ///< nodes that the traversal came to, culled ones included
  std::uint32_t emitted = 0;
  std::uint32_t out_of_view = 0;  ///< leaves of the nodes that were culled
};

/// The finest level at which a cut can emit nodes, whatever the tree: all nodes of this level that
/// hold a point within `bounds` and are not culled are too small to be divided. 0 to kMaxDepth,
/// which it also is where no level is too fine (an eye within the bounds, a pixel size of 0).
/// `cube` is the tree's. Never too coarse; finer than need be where what is nearest is not in the
/// picture.
int finest_level(const Cube& cube, const Box& bounds, const Camera& camera, glm::ivec2 size,
                 float pixel_size);

/// The potentially visible voxels of an octree at the resolution of the picture: paper 2, section
/// VI-B. From the root down, a node whose bounding sphere lies outside the frustum is dropped, and
/// a node is emitted when it has no children or when its projection is too small to matter.
///
/// Too small means, as in the paper, that the projected *area* is below that of a pixel. The area
/// is that of the sphere whose silhouette equals the cube's mean silhouette (6 half^2, a quarter of
/// its surface), exact off the axis too; a node that reaches the near plane never stops (ERRATA
/// 13).
///
/// No node of which a point is visible is ever culled: spheres are widened by the rounding error of
/// the arithmetic. A node whose sphere lies inside the frustum passes that on to its descendants,
/// which are tested no more.
///
/// Keeps its buffers between calls.
class VoxelCut {
 public:
  /// `size`: of the picture in pixels, both > 0. `pixel_size`: edge in pixels of the square whose
  /// area stops the descent; 1 is the paper's criterion, 0 descends to the leaves.
  CutStats run(const Svo& svo, const Camera& camera, glm::ivec2 size, float pixel_size);

  /// What the last run emitted, coarser levels first; valid until the next run.
  std::span<const CutNode> nodes() const { return {nodes_.data(), emitted_}; }

 private:
  /// The cell's coordinates on its level, and the node.
  using Item = std::array<std::int32_t, 4>;

  /// Written without growing: no cut has more nodes than the tree has leaves, no list of a level
  /// more than the level, plus what is written ahead. So these only ever become larger, and
  /// `emitted_` counts.
  std::vector<CutNode> nodes_;
  std::size_t emitted_ = 0;
  std::vector<Item> inside_, next_inside_;
  std::vector<Item> crossing_, next_crossing_;
};

}  // namespace pointreel
