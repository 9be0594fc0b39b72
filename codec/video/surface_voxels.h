#pragma once

#include "pointreel/cloud.h"
#include "pointreel/executor.h"

namespace pointreel {

/// The voxels of this edge that the surface of a decoded frame of video crosses, for comparing and
/// archiving: a cloud of their centres, in Morton order, with mean colours and normals.
///
/// Each point stands for the piece of its tangent plane in the column of one voxel, along the axis
/// that its normal is closest to. The column's voxels are those that the middle part of this piece
/// crosses: all of it would make slopes twice as thick. A point without a normal is one voxel.
///
/// The cloud's positions are finite, and its origin is a corner of a voxel. Points a million voxels
/// away from it are left out.
PointCloud surface_voxels(const PointCloud& cloud, double edge, const Executor& executor = {});

}  // namespace pointreel
