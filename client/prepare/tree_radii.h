#pragma once

#include <vector>

#include "common/octree/build.h"
#include "pointreel/octree.h"

namespace pointreel {

/// Splat radii from an octree that is there anyway: the edge of a square of the surface that holds
/// one point, so that discs of this radius overlap about threefold. A hundredth of the time that
/// looking at each point's neighbours takes (surface/normals.h), and one radius for a whole block of
/// points instead of one for each.
///
/// A tree that was divided until nearly every point has a leaf of its own (the delta criterion) has
/// gaps between its leaves, so their size says too little. The surface is therefore measured where
/// the tree still looks closed, where each level has about four times the nodes of the one above
/// it: a surface meets 1.5 cells for each cell's face of its area, the mean of |nx| + |ny| + |nz|
/// over all directions. Each block of 4^3 such cells gives one radius, at most three times that of
/// the whole surface.

/// Of the centres of the leaves, in their order. At least half a leaf's diagonal, so that the splat
/// covers whatever surface passes through the leaf.
std::vector<float> leaf_radii(const Svo& svo);

/// Of the points that the tree was built from, in the order of the cloud. Points that share a cell
/// at sorted.levels count once.
std::vector<float> point_radii(const Svo& svo, const SortedPoints& sorted);

}  // namespace pointreel
