#include "client/web/wasm/video.h"

#include <cstddef>
#include <cstdint>
#include <utility>

#include "client/source/video_groups.h"
#include "client/web/wasm/errors.h"
#include "codec/video/video_frame.h"

using namespace pointreel;

struct PrVideo {
  VideoFrameReader reader;
};

namespace {

struct ReadFrame : PrVideoFrame {
  explicit ReadFrame(const PrVideoFrame& facts, VideoPictures read)
      : PrVideoFrame(facts), pictures(std::move(read)) {}

  VideoPictures pictures;  // without planes
};

}  // namespace

PrVideo* pr_video_new() { return new PrVideo; }
void pr_video_free(PrVideo* video) { delete video; }

PrVideoFrame* pr_video_read(PrVideo* video, const std::uint8_t* bytes, const std::uint32_t* sizes,
                            double max_memory) {
  const Chunks<std::uint32_t> chunks{sizes[0], sizes[1], sizes[2]};
  DecodeLimits limits;
  if (max_memory > 0.0) limits.max_memory = static_cast<std::uint64_t>(max_memory);
  auto frame = video->reader.next(
      chunk_views({bytes, static_cast<std::size_t>(total(chunks))}, chunks), limits);
  if (!frame) {
    report(frame.error());
    return nullptr;
  }
  const auto at = [bytes](ByteView unit) {
    return unit.empty() ? 0.0 : static_cast<double>(unit.data() - bytes);
  };
  const PrVideoFrame facts{static_cast<double>(frame->group->width),
                           static_cast<double>(frame->group->height),
                           at(frame->depth),
                           static_cast<double>(frame->depth.size()),
                           at(frame->colors),
                           static_cast<double>(frame->colors.size())};
  return new ReadFrame(facts, undecoded(*std::move(frame)));
}

void pr_video_frame_free(PrVideoFrame* frame) { delete static_cast<ReadFrame*>(frame); }

namespace pointreel {

Result<DecodedFrame> video_frame(const PrVideoFrame& frame, const std::uint16_t* depth,
                                 const std::uint8_t* colors, const DecodeLimits& limits) {
  VideoPictures pictures = static_cast<const ReadFrame&>(frame).pictures;
  const std::ptrdiff_t width = pictures.group->width;
  const std::ptrdiff_t pixels = width * pictures.group->height;
  pictures.depth.depth = {depth, width};
  if (colors != nullptr) {
    const std::uint8_t* const chroma = colors + pixels;
    pictures.colors = Av1Picture{
        nullptr, {}, {colors, width}, {chroma, width / 2}, {chroma + pixels / 4, width / 2}};
  }
  return frame_of(pictures, limits);
}

// Frames of video come to the module with their pictures (pr_prepare_video), never as bytes alone.
Result<DecodedFrame> decode_video(const FetchedLayer&, const DecodeLimits&) {
  return fail(ErrorCode::unsupported, "the browser has to decode the frame's video");
}

}  // namespace pointreel
