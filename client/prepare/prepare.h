#pragma once

#include "client/scene/frame.h"
#include "client/source/source.h"

namespace pointreel {

struct PrepareOptions {
  DrawMode mode = DrawMode::surfel;
  /// >= 0, of the tree that voxels are drawn from (DepthRule::delta). Far above the paper's 0.05,
  /// which gives nearly every point a voxel of its own, with gaps between them wherever points are
  /// not on a grid; below 0.75, at which points that are on one would lose a level.
  double delta = 0.72;
  int level = kWholeFrame;    ///< no finer level of detail will be seen
  bool show_normals = false;  ///< in every mode
};

/// Makes a fetched frame ready to draw: decodes it, and derives what the mode needs and the source
/// does not have. `index` is the frame's in the manifest.
///
/// An octree frame stays the tree that it is, down to `level`, with the attributes of its nodes,
/// and without positions. For voxels it is cut off where a coarser level already satisfies delta
/// (which refers to the source's points).
///
/// Of other frames surfels and points draw the cloud, unless so many of its points fall together at
/// `level` that building a tree of that depth pays. Voxels draw a tree that is built to satisfy
/// delta, or to `level`. Trees are built in the segment's cube, or, for files, in the frame's
/// bounding cube. Gaps between voxels are filled (gap_filling.h).
///
/// Normals are estimated from neighbours where absent and needed; radii are made in surfel mode,
/// where absent, from the tree (tree_radii.h, node_radii.h).
///
/// Fills decode_ms (bytes to cloud or tree), normals_ms (their estimation) and svo_ms (tree,
/// attributes and radii), and what it knows of level, points and layers. Trusts nothing in the
/// bytes. Large frames are decoded by several threads of the caller's TBB arena, where it has idle
/// ones.
Result<SceneFrame> prepare_frame(const Manifest& manifest, std::uint32_t index,
                                 const FetchedFrame& fetched, const PrepareOptions& options);

}  // namespace pointreel
