#pragma once

#include <optional>

#include "codec/core/lattice.h"
#include "codec/package/encoding_options.h"
#include "pointreel/draco.h"
#include "pointreel/error.h"
#include "pointreel/geometry.h"

namespace pointreel {

/// The cube in which points are encoded, and the options to encode them with: a given voxel size
/// fixes the depth, and voxelised points are not divided further than their own voxels.
struct Grid {
  Cube cube;
  EncodeOptions encode;
};

/// The grid for points within `box`. With `lattice` the voxels of the octree's leaves, or of
/// Draco's grid, are those of the lattice. If EncodingOptions::voxel is given, they have that size,
/// and their centres are those of the lattice's voxels that they merge. Errors: `argument` if
/// EncodingOptions::voxel needs too deep an octree.
Result<Grid> grid_for(const Box& box, const EncodingOptions& options,
                      const std::optional<PointLattice>& lattice = {});

/// Whether cleaned frames are divided into cells that fit their points: with octrees whose depth
/// was not fixed, unless EncodingOptions::cells_fit_cleaned says otherwise.
bool cells_follow_points(const EncodingOptions& options);

/// A lattice whose step is at most `cell`. Steps are powers of the eighth root of two, so that
/// frames whose points are cleaned to nearly the same cells share one.
PointLattice lattice_for_cells(double cell);

/// Whether a cloud within `box`, whose points lie on the lattice, would be divided down to the
/// voxels of the lattice. Only then does coding it on them pay.
bool reaches(const PointLattice& lattice, const Box& box, const PointCloud& cloud,
             const EncodeOptions& options);

}  // namespace pointreel
