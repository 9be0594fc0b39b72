#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

#include "datasets_synthetic/motion.h"
#include "datasets_synthetic/samplers/ldc.h"
#include "datasets_synthetic/samplers/scan.h"
#include "datasets_synthetic/voxelize.h"
#include "pointreel/cloud.h"
#include "pointreel/error.h"

namespace pointreel {

enum class Sampler {
  scan,  ///< curves that cameras and projectors measure, with their errors: as the paper's clouds
  uniform,  ///< uniform by area, on the surface itself
  ldc,      ///< a layered depth cube: where three bundles of parallel rays meet the surface
};

struct SequenceOptions {
  Sampler sampler = Sampler::scan;
  /// A frame; 0: as many as the paper's sequence of that name has on average (paper 2, Table I),
  /// 90,000 for other motions. A scan has about so many on average over the motion.
  /// A layered depth cube has as many as its rays have hits.
  std::size_t points = 0;
  LdcOptions ldc;
  /// Instead of what the sampler gives, all voxels that the surface passes through (voxelize.h).
  std::optional<VoxelGrid> voxels;
  double fps = 30.0;  ///< > 0
  std::uint64_t seed = 1;
  double noise = 0.0;  ///< standard deviation along each axis, metres; added to a scan's own
};

/// Bounds that hold the figure in each of the first `frames` frames, up to 15 mm of air included.
Box sequence_bounds(const Motion& motion, double fps, int frames);

/// The points a frame that the options aim at.
std::size_t points_per_frame(const Motion& motion, const SequenceOptions& options);

/// Settings of the scanner that give about so many points a frame of this motion.
ScanOptions scan_options(const Motion& motion, std::size_t points);

/// Frame `number` of the motion: metres, y up, standing on y = 0 (but for noise), facing +z; with
/// 8-bit colours. Every frame is sampled anew. A scan has normals and radii estimated from its
/// points (the paper's clouds have no colours: the pattern covers them), other points their true
/// normals. A function of its arguments alone, the same bytes on every machine and with any number
/// of threads.
Result<PointCloud> sequence_frame(const Motion& motion, const SequenceOptions& options, int number);

}  // namespace pointreel
