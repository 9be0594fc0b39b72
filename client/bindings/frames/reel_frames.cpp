#include "client/bindings/frames/reel_frames.h"

#include "common/base/concat.h"
#include "common/base/try.h"

namespace pointreel {

Result<std::uint32_t> ReelFrames::number(std::uint32_t index) const {
  if (index < size()) return shown_[index];
  return fail(ErrorCode::argument,
              concat("there is no frame ", index, "; the reel has ", size(), " frames"));
}

Result<std::uint64_t> ReelFrames::time_us(std::uint32_t index) const {
  return frame_time_us(manifest(), TRY(number(index)));
}

Result<SharedFrame> ReelFrames::read(std::uint32_t index, const ReadLimits& limits) const {
  FetchRequest request;
  request.frame = TRY(number(index));
  if (limits.layers == 0) return fail(ErrorCode::argument, "a frame has at least one layer");
  request.layers.end = limits.layers;
  request.stop = limits.stop;
  FrameInfo info = frame_info(manifest(), request.frame);
  info.index = index;
  auto frame = decode_points(TRY(source_->fetch(request)), info, limits, manifest().up);
  if (!frame && manifest().codec != "files") return fail_at(concat("frame ", index), frame.error());
  return frame;
}

}  // namespace pointreel
