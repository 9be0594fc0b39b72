#pragma once

#include "pointreel/draco.h"
#include "pointreel/error.h"
#include "pointreel/geometry.h"
#include "server/encode/encoding_options.h"

namespace pointreel {

/// The cube in which points are encoded, and the options to encode them with: a given voxel size
/// fixes the depth.
struct Grid {
  Cube cube;
  EncodeOptions encode;
};

/// The grid for points within `box`. An error if EncodingOptions::voxel needs too deep an octree.
Result<Grid> grid_for(const Box& box, const EncodingOptions& options);

}  // namespace pointreel
