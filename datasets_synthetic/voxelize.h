#pragma once

#include <glm/glm.hpp>

#include "datasets_synthetic/body.h"
#include "datasets_synthetic/surface_grid.h"
#include "pointreel/cloud.h"
#include "pointreel/error.h"
#include "pointreel/geometry.h"

namespace pointreel {

/// A grid of 2^bits voxels along each axis. Voxel (i, j, k) is the cube of edge `voxel` centred at
/// origin + voxel * (i, j, k).
struct VoxelGrid {
  glm::dvec3 origin{0.0};
  double voxel = 1.0;  ///< edge of a voxel, metres
  int bits = 10;       ///< 1 to 12
};

/// The grid in which the largest extent of the box measures 2^bits - 1 voxels, as in MPEG's
/// sequences: after rounding to the nearest voxel, the smallest coordinate is 0 and the largest
/// 2^bits - 1.
VoxelGrid voxel_grid(const Box& box, int bits);

/// The body as a dense cloud without duplicates: one point, at its integer coordinates (floats),
/// for each voxel that the surface passes through, in Morton order. Its normal and its colour
/// (8-bit sRGB) are the means over the points where the edges of the voxel meet the surface.
///
/// A ray is cast along every edge of the grid, and the cloud has exactly those voxels of which an
/// edge meets the surface. So the voxels of a connected surface are connected by faces, edges or
/// corners, and no chain of empty voxels joined by faces leads from outside to inside. A tip that
/// pokes less than a voxel into a face touches no edge, and its voxel is missing: one in 3,000 for
/// a person at 6 bits. There are about 1.5 area / voxel^2 points. The result depends on the
/// arguments only.
Result<PointCloud> voxelize(const Body& body, const VoxelGrid& grid);

}  // namespace pointreel
