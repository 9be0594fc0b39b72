#pragma once

#include <optional>

#include "common/cloud/lattice.h"
#include "pointreel/draco.h"
#include "pointreel/error.h"
#include "pointreel/geometry.h"
#include "server/encode/encoding_options.h"

namespace pointreel {

/// The cube in which points are encoded, and the options to encode them with: a given voxel size
/// fixes the depth, and voxelised points are not divided further than their own voxels.
struct Grid {
  Cube cube;
  EncodeOptions encode;
};

/// The grid for points within `box`. With `lattice` the voxels of the octree's leaves, or of
/// Draco's grid, are those of the lattice, unless EncodingOptions::voxel is given. Errors:
/// `argument` if EncodingOptions::voxel needs too deep an octree.
Result<Grid> grid_for(const Box& box, const EncodingOptions& options,
                      const std::optional<PointLattice>& lattice = {});

/// Whether the cells of cleaned frames follow the spacing of their points: with octrees whose depth
/// was not fixed.
bool cells_follow_spacing(const EncodingOptions& options);

/// A lattice for cleaned points that are `spacing` apart. Its step is about half of that: finer
/// cells would tell points apart that are samples of the same spot, coarser ones would show. Steps
/// are powers of the eighth root of two, so that frames of nearly the same spacing share one.
PointLattice lattice_for_spacing(double spacing);

/// Whether a cloud within `box`, whose points lie on the lattice, would be divided down to the
/// voxels of the lattice. Only then does coding it on them pay.
bool reaches(const PointLattice& lattice, const Box& box, const PointCloud& cloud,
             const EncodeOptions& options);

}  // namespace pointreel
