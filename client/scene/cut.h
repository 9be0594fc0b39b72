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
  std::uint32_t visited = 0;  ///< nodes that the traversal reached, culled ones included
  std::uint32_t emitted = 0;
  std::uint32_t out_of_view = 0;  ///< leaves below the nodes that were culled
};

/// The finest level at which a cut can emit nodes, for any tree in this cube: all nodes of this
/// level that hold a point within `bounds` and are not culled are too small to be divided. 0 to
/// kMaxDepth; kMaxDepth also if no level is too fine (an eye within the bounds, a pixel size of 0).
/// The result is never too coarse. It is finer than necessary if the nearest part of the bounds is
/// not in the picture.
int finest_level(const Cube& cube, const Box& bounds, const Camera& camera, glm::ivec2 size,
                 float pixel_size);

/// The potentially visible voxels of an octree at the resolution of the picture (Slomp et al.,
/// Geometry Instancing, section VI-B). Going down from the root, a node whose bounding sphere lies
/// outside the frustum is dropped, and a node is emitted if it has no children or if its projection
/// is too small to matter.
///
/// As in the paper, too small means that the projected *area* is below that of a pixel. The area is
/// that of the sphere whose silhouette equals the cube's mean silhouette (6 half^2, a quarter of
/// its surface), exact off the axis too. A node that reaches the near plane is always divided
/// (common/FORMULAS.md, "Projected size" and "Frustum test").
///
/// A node with a visible point is never culled: spheres are widened by the rounding error of the
/// arithmetic. Once a node's sphere lies inside the frustum, its descendants are not tested again.
///
/// Keeps its buffers between calls.
class VoxelCut {
 public:
  /// `size`: of the picture in pixels, both > 0. `pixel_size`: a node whose projection is smaller
  /// than a square with this edge in pixels is not divided; 1 is the paper's criterion, 0 goes down
  /// to the leaves.
  CutStats run(const Svo& svo, const Camera& camera, glm::ivec2 size, float pixel_size);

  /// The nodes that the last run emitted, coarser levels first; valid until the next run.
  std::span<const CutNode> nodes() const { return {nodes_.data(), emitted_}; }

 private:
  /// A cell's coordinates on its level, and its node.
  using Item = std::array<std::int32_t, 4>;

  /// The lists are made large enough before they are written: a cut has no more nodes than the tree
  /// has leaves, and a list of a level no more than the level, plus what is written ahead. They are
  /// never shrunk; `emitted_` is the number of nodes in use.
  std::vector<CutNode> nodes_;
  std::size_t emitted_ = 0;
  std::vector<Item> inside_, next_inside_;
  std::vector<Item> crossing_, next_crossing_;
};

}  // namespace pointreel
