#pragma once

#include <cstdint>
#include <vector>

#include "codec/video/video_group.h"
#include "codec/video_encode/decoded_points.h"
#include "codec/video_encode/surface_points.h"
#include "pointreel/executor.h"

namespace pointreel {

/// The points of the source that have to be kept beside the pictures, so that at most one of a
/// thousand lies farther than two pixels from anything that is decoded, and none so far that it is
/// missed. The farthest are kept first; one that lies near another that is kept is not.
std::vector<std::uint32_t> leftovers(const VideoGroup& group, const DecodedDepth& decoded,
                                     const SurfacePoints& source, const Executor& executor = {});

}  // namespace pointreel
