#include "codec/video/video_decoder.h"

#include <utility>

#include "common/base/for_each.h"
#include "common/base/out_of_memory.h"
#include "common/base/try.h"

namespace pointreel {

Result<VideoPictures> VideoDecoder::next(const Chunks<ByteView>& chunks,
                                         const DecodeLimits& limits) {
  CodedVideoFrame frame = TRY(reader_.next(chunks, limits));
  auto pictures = or_out_of_memory([&] { return decode(std::move(frame), limits.executor); });
  if (!pictures) reader_.reset();
  return pictures;
}

Result<VideoPictures> VideoDecoder::decode(CodedVideoFrame frame, const Executor& executor) {
  const VideoGroup& group = *frame.group;
  if (frame.index == 0) {
    depth_ = TRY(Av1Decoder::open({group.width, group.height, 10}));
    colors_.reset();
    if (!frame.colors.empty()) colors_ = TRY(Av1Decoder::open({group.width, group.height, 8}));
  }
  const bool with_colors = !frame.colors.empty();
  // The two videos at the same time.
  Result<Av1Picture> depth, colors;
  for_each(executor, with_colors ? 2 : 1, [&](int i) {
    if (i == 0) {
      depth = depth_->decode(frame.depth);
    } else {
      colors = colors_->decode(frame.colors);
    }
  });
  VideoPictures pictures = undecoded(std::move(frame));
  pictures.depth = TRY(std::move(depth));
  if (with_colors) pictures.colors = TRY(std::move(colors));
  return pictures;
}

}  // namespace pointreel
