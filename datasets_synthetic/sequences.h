#pragma once

#include <cstddef>
#include <cstdint>

#include "common/base/error.h"
#include "common/cloud/point_cloud.h"
#include "datasets_synthetic/motion.h"

namespace pointreel {

struct SequenceOptions {
  std::size_t points = 90000;  ///< a frame
  double fps = 30.0;           ///< > 0
  std::uint64_t seed = 1;
  double noise = 0.0;  ///< standard deviation along each axis, metres
};

/// Frame `number` of the motion: metres, y up, standing on y = 0 (but for noise), facing +z; with
/// the true normals and 8-bit colours. Every frame is sampled anew, as a scanner does. A function
/// of its arguments alone, the same bytes on every machine and with any number of threads.
Result<PointCloud> sequence_frame(const Motion& motion, const SequenceOptions& options, int number);

}  // namespace pointreel
