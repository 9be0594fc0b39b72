#pragma once

#include <cstdint>
#include <vector>

#include "pointreel/octree.h"

namespace pointreel {

/// Scanned points lie along curves, so at the level at which most of them have a voxel of their own
/// there are gaps between the voxels, through which the eye sees what is behind. A coarser level is
/// closed but coarse. So the gaps are filled instead, with voxels of the same size: an empty cell
/// is filled where it lies between two leaves, along one of the 13 lines through it and its
/// neighbours. That closes nets and random holes, keeps outlines, makes no surface thicker, and
/// lets single points stay single.

/// The widest gap, in cells, that is worth filling in a tree of so many points (duplicates
/// included), 0 to 3: none where the leaves already meet, or are so much finer than the gaps that
/// these would stay.
int gap_to_fill(const Svo& svo, std::uint32_t points);

/// Which nodes there are only because they or leaves below them were filled in; empty: none.
using FilledNodes = std::vector<bool>;

/// Fills gaps of at most `widest` cells (1 to 3), but only within those nodes two levels above the
/// leaves that are there: of what is between the leaves of scans hardly anything is outside of
/// them. New leaves have the mean attributes of the leaves that touch them, and what is further
/// away those of new ones; attributes of nodes that were there do not change. `attributes` are
/// those of all nodes, as before and as they are left.
FilledNodes fill_gaps(Svo& svo, NodeAttributes& attributes, int widest);

}  // namespace pointreel
