#pragma once

#include <span>
#include <string>
#include <vector>

#include "pointreel/bytes.h"
#include "pointreel/chunks.h"
#include "pointreel/cloud.h"
#include "pointreel/error.h"
#include "pointreel/executor.h"

namespace pointreel {

/// How a group of frames becomes layered depth video.
struct VideoOptions {
  double pitch = 1.0;  ///< the edge of a pixel, in the units of the source
  int side = 1024;     ///< pixels along the cube that frames lie in, 16 to kLargestAtlas / 2
  int depth_quantizer = 16, color_quantizer = 38;  ///< 0 (fine) to 63
  int preset = 8;                                  ///< SVT-AV1's, 0 (slow) to 12 (fast)
  bool colors = true;  ///< whether to encode colours, where frames have any
  int threads = 1;     ///< of the video encoder; the bytes do not depend on it
  Executor executor = {};
};

/// Encodes a group of 1 to kMostGroupFrames frames, whose cube begins at `corner`. All frames have
/// normals that point outward (complete_normals). Returns the chunks of each frame, which
/// VideoDecoder takes.
///
/// Errors: `argument` for options out of range, frames without normals, and colours that only some
/// frames have; `limit` if pixels are too small for the format, if the views need larger pictures
/// than kLargestAtlas, or if the encoder fails.
Result<std::vector<Chunks<Bytes>>> encode_video_group(std::span<const PointCloud* const> frames,
                                                      const glm::dvec3& corner,
                                                      const VideoOptions& options);

}  // namespace pointreel
