#pragma once

#include <optional>

#include "codec/video/av1_decoder.h"
#include "codec/video/video_frame.h"
#include "pointreel/bytes.h"
#include "pointreel/chunks.h"
#include "pointreel/codec.h"
#include "pointreel/error.h"

namespace pointreel {

/// Decodes the frames of a group, one after another: VideoFrameReader, and dav1d for AV1.
///
/// Trust: the bytes may be hostile; both say how they are read. Any bytes give pictures or an
/// error.
class VideoDecoder {
 public:
  /// Decodes the next frame of a group, or the first one of a new group. Errors, and frames without
  /// colours: VideoFrameReader::next.
  Result<VideoPictures> next(const Chunks<ByteView>& chunks, const DecodeLimits& limits = {});

 private:
  Result<VideoPictures> decode(CodedVideoFrame frame, const Executor& executor);

  VideoFrameReader reader_;
  std::optional<Av1Decoder> depth_, colors_;
};

}  // namespace pointreel
