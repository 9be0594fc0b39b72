#include "codec/package/grid.h"

#include <cmath>

#include <fmt/format.h>

#include "codec/core/build.h"
#include "codec/octree/frame_header.h"
#include "codec/package/coarsening.h"
#include "pointreel/octree.h"

namespace pointreel {
namespace {

/// The lattice on whose points voxels of this size are centred. If they merge those of the source,
/// they are centred on what they merge, or else everything would move by half a voxel of the
/// source. Otherwise they are centred on multiples of their size.
PointLattice voxel_centers(double voxel, const std::optional<PointLattice>& source) {
  if (source) {
    const double merged = std::round(voxel / source->step);
    if (merged >= 1.0 && std::abs(voxel / source->step - merged) < 1e-6) {
      const bool even = std::fmod(merged, 2.0) == 0.0;
      return {source->point + (even ? 0.5 * source->step : 0.0), voxel};
    }
  }
  return {glm::dvec3(0.0), voxel};
}

}  // namespace

Result<Grid> grid_for(const Box& box, const EncodingOptions& options,
                      const std::optional<PointLattice>& lattice) {
  if (options.voxel) {
    const VoxelCube voxels = lattice_cube(box, voxel_centers(*options.voxel, lattice));
    if (voxels.depth > kMaxDepth) {
      return fail(
          ErrorCode::argument,
          fmt::format("voxels of {} need an octree deeper than {} levels here: give a "
                      "larger {}",
                      *options.voxel, kMaxDepth, options.resample ? "--spacing" : "--voxel"));
    }
    if (!is_codable(voxels.cube)) {
      return fail(ErrorCode::argument,
                  fmt::format("voxels of {} are too {} to be coded: give a {} {}", *options.voxel,
                              *options.voxel > 1.0 ? "large" : "small",
                              *options.voxel > 1.0 ? "smaller" : "larger",
                              options.resample ? "--spacing" : "--voxel"));
    }
    Grid grid{voxels.cube, options.encode};
    std::get<OctreeOptions>(grid.encode.codec).depth = DepthRule::fixed(voxels.depth);
    return grid;
  }
  if (!lattice || box.empty()) return Grid{bounding_cube(box), options.encode};
  const VoxelCube voxels = lattice_cube(box, *lattice);
  return Grid{voxels.cube, no_deeper_than(options.encode, voxels.depth)};
}

bool cells_follow_points(const EncodingOptions& options) {
  const auto* octree = std::get_if<OctreeOptions>(&options.encode.codec);
  return octree != nullptr && octree->depth.kind == DepthRule::Kind::delta && !options.voxel &&
         options.cells_fit_cleaned;
}

PointLattice lattice_for_cells(double cell) {
  // From multiplications only, because the last bit of libm's functions differs between machines.
  constexpr double kFactor = 1.0905077326652577;
  int exponent = 0;
  const double mantissa = std::frexp(cell, &exponent);
  double step = 0.5;
  while (step * kFactor <= mantissa) step *= kFactor;
  return {glm::dvec3(0.0), std::ldexp(step, exponent)};
}

bool reaches(const PointLattice& lattice, const Box& box, const PointCloud& cloud,
             const EncodeOptions& options) {
  const VoxelCube voxels = lattice_cube(box, lattice);
  if (voxels.depth == 0) return false;  // a single voxel is no evidence, and Draco has no such grid
  const auto* octree = std::get_if<OctreeOptions>(&options.codec);
  if (octree == nullptr) {
    return voxels.depth <= std::get<DracoOptions>(options.codec).position_bits;
  }
  DepthRule rule = coding_rule(octree->depth, cloud.size());
  if (voxels.depth > rule.most) return false;
  if (rule.kind == DepthRule::Kind::fixed) return voxels.depth <= rule.depth;
  rule.most = voxels.depth;
  const Result<SortedToDepth> sorted = sort_to_depth(cloud, voxels.cube, rule);
  return sorted && sorted->depth == voxels.depth;
}

}  // namespace pointreel
