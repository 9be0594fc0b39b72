#include "server/encode/grid.h"

#include <fmt/format.h>

#include "pointreel/octree.h"

namespace pointreel {

Result<Grid> grid_for(const Box& box, const EncodingOptions& options) {
  if (!options.voxel) return Grid{bounding_cube(box), options.encode};
  const VoxelCube voxels = voxel_cube(box, *options.voxel);
  if (voxels.depth > kMaxDepth) {
    return fail(
        ErrorCode::argument,
        fmt::format("voxels of {} need an octree deeper than {} levels here: give a larger --voxel",
                    *options.voxel, kMaxDepth));
  }
  Grid grid{voxels.cube, options.encode};
  std::get<OctreeOptions>(grid.encode.codec).depth = DepthRule::fixed(voxels.depth);
  return grid;
}

}  // namespace pointreel
