#pragma once

#include "client/source/fetched.h"
#include "pointreel/codec.h"
#include "pointreel/error.h"

namespace pointreel {

/// A frame of video (frame_of). `layer.group` is not null. Decoders of the last few groups are
/// kept, so that frames that follow each other are decoded once each; any other frame takes the
/// decoding of those before it in its group, too. Safe to call from any thread.
Result<DecodedFrame> decode_video(const FetchedLayer& layer, const DecodeLimits& limits);

}  // namespace pointreel
