#pragma once

#include <cstdint>
#include <memory>
#include <stop_token>

#include "client/prepare/prepare.h"
#include "client/source/fetched.h"
#include "client/source/live_source.h"
#include "pointreel/cloud.h"
#include "pointreel/error.h"
#include "pointreel/up.h"

/// Frames as points, for programs in other languages.
namespace pointreel {

/// A decoded frame. It does not change, so that threads and languages may share it.
struct PointFrame {
  PointCloud cloud;
  FrameInfo info;            ///< with the cube of the frame
  Up up = 'y';               ///< of its reel or stream
  std::uint32_t layers = 0;  ///< that it was decoded from; 0 for a file
  FetchedFrame fetched;      ///< what it was decoded from, to be drawn
};
using SharedFrame = std::shared_ptr<const PointFrame>;

struct ReadLimits {
  std::uint32_t layers = kAllLayers;        ///< at least 1; files come whole
  std::uint64_t max_memory = kFrameMemory;  ///< DecodeLimits::max_memory
  std::stop_token stop = {};                ///< asked to stop, reading fails soon (`cancelled`)
};

/// Decodes what was fetched of a frame, on the idle threads of the caller's TBB arena as well.
Result<SharedFrame> decode_points(FetchedFrame fetched, const FrameInfo& info,
                                  const ReadLimits& limits, Up up = 'y');

/// The same of a live frame.
Result<SharedFrame> decode_live(LiveFrame frame, const ReadLimits& limits, Up up = 'y');

}  // namespace pointreel
