#pragma once

#include "pointreel/cloud.h"
#include "pointreel/geometry.h"
#include "pointreel/octree.h"

namespace pointreel {

// The box of a frame without its outermost points, at most one in 200 on each side: a single point
// far away does not make it larger. It is estimated from some thousand points, and has a margin of
// a twentieth of its extent. Empty if there are no points.

Box main_box(const PointCloud& cloud);
/// Counts the nodes of the first level that has enough of them, with their whole cells.
Box main_box(const Svo& svo);

}  // namespace pointreel
