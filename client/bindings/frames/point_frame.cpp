#include "client/bindings/frames/point_frame.h"

#include <algorithm>
#include <utility>

#include "client/source/decode_fetched.h"
#include "common/base/out_of_memory.h"
#include "common/base/try.h"
#include "common/threads/tbb_executor.h"

namespace pointreel {

Result<SharedFrame> decode_points(FetchedFrame fetched, const FrameInfo& info,
                                  const ReadLimits& limits, Up up) {
  return or_out_of_memory([&]() -> Result<SharedFrame> {
    DecodeLimits decode;
    decode.max_memory = limits.max_memory;
    decode.executor = tbb_executor();
    if (limits.stop.stop_possible())
      decode.stopped = [stop = limits.stop] { return stop.stop_requested(); };
    DecodedFrame decoded = TRY(decode_fetched(fetched, decode));
    auto frame = std::make_shared<PointFrame>();
    frame->cloud = std::move(decoded.cloud);
    frame->info = info;
    frame->info.cube = decoded.cube;
    frame->up = up;
    frame->layers = static_cast<std::uint32_t>(fetched.layers.size());
    frame->fetched = std::move(fetched);
    return frame;
  });
}

Result<SharedFrame> decode_live(LiveFrame frame, const ReadLimits& limits, Up up) {
  const std::size_t layers = std::max<std::size_t>(1, limits.layers);
  if (frame.frame.layers.size() > layers) frame.frame.layers.resize(layers);
  return decode_points(std::move(frame.frame), {frame.number, frame.capture_us, {}}, limits, up);
}

}  // namespace pointreel
