#pragma once

#include "pointreel/codec.h"
#include "pointreel/draco.h"
#include "pointreel/error.h"
#include "pointreel/geometry.h"
#include "server/pack/pack_options.h"

namespace pointreel {

/// The cube that encodes points within a box, and what the voxel size makes of the depth.
struct Grid {
  Cube cube;
  EncodeOptions encode;
};
Result<Grid> grid_for(const Box& box, const PackOptions& options);

}  // namespace pointreel
