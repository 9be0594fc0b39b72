#include "client/bindings/frames/point_frame.h"

#include <algorithm>
#include <utility>

#include "client/source/decode_fetched.h"
#include "common/base/concat.h"
#include "common/base/out_of_memory.h"
#include "common/base/try.h"
#include "common/threads/tbb_executor.h"

namespace pointreel {

Result<SharedFrame> decode_points(FetchedFrame fetched, const FrameInfo& info,
                                  const ReadLimits& limits) {
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
    frame->layers = static_cast<std::uint32_t>(fetched.layers.size());
    frame->fetched = std::move(fetched);
    return frame;
  });
}

Result<SharedFrame> read_points(Source& source, std::uint32_t frame, const ReadLimits& limits) {
  const Manifest& manifest = source.manifest();
  if (frame >= manifest.frame_count())
    return fail(ErrorCode::argument, concat("there is no frame ", frame, "; the reel has ",
                                            manifest.frame_count(), " frames"));
  if (limits.layers == 0) return fail(ErrorCode::argument, "a frame has at least one layer");
  FetchRequest request;
  request.frame = frame;
  request.layers.end = limits.layers;
  request.stop = limits.stop;
  const FrameInfo info = frame_info(manifest, frame);
  auto read = decode_points(TRY(source.fetch(request)), info, limits);
  if (!read && manifest.codec != "files") return fail_at(concat("frame ", frame), read.error());
  return read;
}

Result<SharedFrame> decode_live(LiveFrame frame, const ReadLimits& limits) {
  const std::size_t layers = std::max<std::size_t>(1, limits.layers);
  if (frame.frame.layers.size() > layers) frame.frame.layers.resize(layers);
  return decode_points(std::move(frame.frame), {frame.number, frame.capture_us, {}}, limits);
}

}  // namespace pointreel
