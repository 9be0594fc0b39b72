#pragma once

#include <cstdint>

#include "client/web/wasm/module.h"
#include "pointreel/codec.h"
#include "pointreel/error.h"

namespace pointreel {

/// A frame of video with its pictures, as pr_prepare_video gets them.
Result<DecodedFrame> video_frame(const PrVideoFrame& frame, const std::uint16_t* depth,
                                 const std::uint8_t* colors, const DecodeLimits& limits);

}  // namespace pointreel
