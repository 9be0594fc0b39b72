#pragma once

#include "client/bindings/frames/point_frame.h"
#include "pointreel/bytes.h"
#include "pointreel/codec.h"
#include "pointreel/error.h"

namespace pointreel {

/// A single frame as bytes: its layers as the messages of a live stream, one after another
/// (PROTOCOL.md, "Live"), with frame and time 0. `limit` if a layer is longer than such a message.
Result<Bytes> frame_bytes(const EncodedFrame& frame);

/// Decodes frame_bytes, or a whole file of points that is recognised by its first bytes.
///
/// Trust: the bytes may be hostile. Headers are checked as those of live streams, layers have to be
/// those of one frame, and codec.h and cloud_file.h say how their content is read.
Result<SharedFrame> decode_bytes(ByteView bytes, const ReadLimits& limits);

}  // namespace pointreel
