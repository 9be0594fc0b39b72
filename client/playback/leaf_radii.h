#pragma once

#include <vector>

#include "common/octree/svo.h"

namespace pointreel {

/// Splat radii for the centres of a tree's leaves, in their order: the edge of a square of the
/// surface that holds one leaf, but at least half a leaf's diagonal, so that the splat covers
/// whatever surface passes through the leaf.
///
/// A tree that was divided until nearly every point has a leaf of its own (the delta criterion) has
/// gaps between its leaves, so their size alone says too little. The surface is therefore measured
/// at the finest level that still looks closed, where each level has about four times the nodes of
/// the one above it: a surface meets 1.5 cells for each cell's face of its area, the mean of
/// |nx| + |ny| + |nz| over all directions. Each block of 4^3 such cells gives one radius.
///
/// Takes a few steps for each block, far fewer than there are leaves: for frames that come without
/// radii and are to be shown at once.
std::vector<float> leaf_radii(const Svo& svo);

}  // namespace pointreel
