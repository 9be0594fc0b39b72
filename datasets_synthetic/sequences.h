#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

#include "datasets_synthetic/motion.h"
#include "datasets_synthetic/samplers/depth_cameras.h"
#include "datasets_synthetic/samplers/ldc.h"
#include "datasets_synthetic/samplers/scan.h"
#include "datasets_synthetic/voxelize.h"
#include "pointreel/cloud.h"
#include "pointreel/error.h"

namespace pointreel {

enum class Sampler {
  /// Curves that cameras and projectors measure, with their errors, as in the clouds of Slomp et
  /// al.
  scan,
  uniform,        ///< uniform by area, exactly on the surface
  ldc,            ///< a layered depth cube: where three bundles of parallel rays meet the surface
  depth_cameras,  ///< what a ring of cameras for depth and colour measures, with its errors
};

struct SequenceOptions {
  Sampler sampler = Sampler::scan;
  /// Points in each frame. 0: as many as the sequence of that name has on average (Slomp et al.,
  /// Geometry Instancing, Table I), or 90,000 for other motions. Scans and captures of depth
  /// cameras have about this many on average over the motion. A layered depth cube ignores this: it
  /// has one point for each hit of a ray.
  std::size_t points = 0;
  LdcOptions ldc;
  /// The width of the pixels follows from `points` (depth_camera_options).
  DepthCameraOptions depth_cameras;
  /// If set, the frame consists of all voxels that the surface passes through (voxelize.h), and the
  /// sampler is not used.
  std::optional<VoxelGrid> voxels;
  double fps = 30.0;   ///< > 0
  bool still = false;  ///< every frame shows the pose of the first; only the sampling differs
  std::uint64_t seed = 1;
  double noise = 0.0;  ///< standard deviation along each axis, metres; on top of a sampler's own
};

/// Bounds that hold the figure in each of the first `frames` frames, with up to 15 mm to spare.
Box sequence_bounds(const Motion& motion, double fps, int frames);

/// The pose that frame `number` shows.
Pose frame_pose(const Motion& motion, const SequenceOptions& options, int number);

/// The number of points that a frame with these options should have.
std::size_t points_per_frame(const Motion& motion, const SequenceOptions& options);

/// Settings of the scanner that give about `points` points per frame of this motion.
ScanOptions scan_options(const Motion& motion, std::size_t points);

/// These depth cameras with pixels that give about `points` points per frame of this motion.
DepthCameraOptions depth_camera_options(const Motion& motion, DepthCameraOptions options,
                                        std::size_t points);

/// Frame `number` of the motion: metres, y up, standing on y = 0 (except for noise), facing +z,
/// with 8-bit colours. Each frame is sampled independently. A scan has normals and radii that are
/// estimated from its points, depth cameras estimate normals from their depth images, and other
/// samplers give the true normals. (The clouds of Slomp et al. have no colours, because the
/// projected pattern covers them.) The result depends on the arguments only: it is the same on
/// every machine and with any number of threads.
Result<PointCloud> sequence_frame(const Motion& motion, const SequenceOptions& options, int number);

}  // namespace pointreel
