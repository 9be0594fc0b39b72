#pragma once

#include "codec/codec.h"
#include "common/base/error.h"
#include "common/cloud/geometry.h"
#include "server/pack/pack_options.h"

namespace pointreel {

/// The cube that encodes points within a box, and what the voxel size makes of the depth.
struct Grid {
  Cube cube;
  EncodeOptions encode;
};
Result<Grid> grid_for(const Box& box, const PackOptions& options);

}  // namespace pointreel
