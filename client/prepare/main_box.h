#pragma once

#include <cstdint>

#include "client/scene/frame.h"
#include "pointreel/cloud.h"
#include "pointreel/octree.h"

namespace pointreel {

// FrameBoxes::main is the box without its outermost points, at most one in 200 on each side: a
// single point far away does not make it larger. It is estimated from some thousand points, and has
// a margin of a twentieth of its extent. Boxes are empty if there are no points.

FrameBoxes frame_boxes(const PointCloud& cloud);
/// Counts the nodes of the first level that has enough of them, with their whole cells. If the tree
/// has too few nodes for that, though they stand for many points, any of them may be one point far
/// away: the outermost does not count. That is rough unless the tree is `whole`. `points`: of the
/// source.
FrameBoxes frame_boxes(const Svo& svo, std::uint32_t points, bool whole);

}  // namespace pointreel
