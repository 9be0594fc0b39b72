#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "pointreel/octree.h"

namespace pointreel {

// Scanned points lie along curves. At the level at which most have a voxel of their own, the
// background shows through gaps. A coarser level has none but shows less. So gaps are filled with
// voxels of the same size: an empty cell is filled if it lies between two leaves along one of the
// 13 lines through it and its neighbours, or nearest to the middle of two that are a knight's move
// or the like apart with no leaf as near to it. That closes nets and random holes, keeps outlines,
// thickens no surface, and adds nothing to single points.

/// The depth of the tree to draw, if delta (DepthRule::delta) chose `depth`: the one above where
/// that closes, the gaps of this one are wider than fill_gaps() can close, and delta was missed by
/// little. Without it, frames of the same scan could change between the two. `occupied` are the
/// numbers of nodes of the levels down to `depth`.
int depth_that_closes(std::span<const std::uint32_t> occupied, std::uint64_t points, int depth,
                      double delta);

/// The widest gap, in cells, that is worth filling in a tree of this many points (duplicates
/// included): 0 to 3. It is 0 if the leaves already meet, or if they are so much finer than the
/// gaps that these would stay.
int gap_to_fill(const Svo& svo, std::uint32_t points);

/// For each node, whether it exists only because it, or a leaf below it, was filled in; empty if
/// there is none.
using FilledNodes = std::vector<bool>;

/// Fills gaps of at most `widest` cells (1 to 3). A new leaf has the mean attributes of the leaves
/// that touch it; where only new leaves do, their mean. A new inner node has that of its children.
/// Attributes of existing nodes do not change. `attributes` holds those of all nodes, before and
/// afterwards.
FilledNodes fill_gaps(Svo& svo, NodeAttributes& attributes, int widest);

}  // namespace pointreel
