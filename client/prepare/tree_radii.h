#pragma once

#include <vector>

#include "codec/core/build.h"
#include "pointreel/octree.h"

namespace pointreel {

// Splat radii from an octree that exists anyway: the edge of a square of the surface that holds one
// point, so that discs of this radius overlap about threefold. This takes a hundredth of the time
// of looking at each point's neighbours (surface/normals.h), and gives one radius to a whole block
// of points instead of one to each.
//
// A tree that was divided until nearly every point has a leaf of its own (the delta criterion) has
// gaps between its leaves, so that their size does not tell the area of the surface. The area is
// therefore measured where the tree still looks closed, which is where each level has about four
// times as many nodes as the level above. There a surface with the area of one cell's face meets
// 1.5 cells, the mean of |nx| + |ny| + |nz| over all directions. Each block of 4^3 such cells gets
// one radius, no more than three times that of the whole surface.

/// Radii for the centres of the leaves, in the order of the leaves. At least half a leaf's
/// diagonal, so that the splat covers any surface that passes through the leaf.
std::vector<float> leaf_radii(const Svo& svo);

/// Radii for the points that the tree was built from, in the order of the cloud. Points that share
/// a cell at sorted.levels count once.
std::vector<float> point_radii(const Svo& svo, const SortedPoints& sorted);

}  // namespace pointreel
