#pragma once

#include "client/scene/frame.h"
#include "client/source/source.h"

namespace pointreel {

struct PrepareOptions {
  DrawMode mode = DrawMode::surfel;
  double delta = 0.7;  ///< >= 0, of the tree that is drawn (DepthRule::delta)
};

/// What of the reel's frames a mode draws: colours always; normals where surfels are oriented by
/// them, or where no colour is there and the fake colour is made from them. (Voxels and points that
/// have colours are lit by their faces and from the eye: normals cost more to send than they show.)
FetchRequest parts_for(const Manifest& manifest, DrawMode mode);

/// Makes a fetched frame ready to draw: decodes it, derives what the mode needs and the source does
/// not have, and builds the tree. `index` is the frame's in the manifest.
///
/// The tree: of an octree frame the decoder's own, cut off where a coarser level already satisfies
/// delta (which refers to the source's points); otherwise built in the segment's cube, or, for
/// files, in the frame's bounding cube. Attributes of its nodes are made in voxel mode only.
///
/// Normals are estimated from neighbours where absent and needed; radii in surfel mode, where
/// absent, from the tree (tree_radii.h).
///
/// Fills decode_ms (bytes to cloud), normals_ms (their estimation) and svo_ms (tree, attributes and
/// radii). Trusts nothing in the bytes. Large frames are decoded by several threads of the
/// caller's TBB arena, where it has idle ones.
Result<SceneFrame> prepare_frame(const Manifest& manifest, std::uint32_t index,
                                 const FetchedFrame& fetched, const PrepareOptions& options);

}  // namespace pointreel
