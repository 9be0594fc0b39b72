#pragma once

#include <vector>

#include "codec/video/pixel_depths.h"
#include "codec/video/video_group.h"

namespace pointreel {

/// What players will decode: the depth of each pixel of the pictures, in pixels along its view's
/// axis from the cube's corner; kNoPoint where there is no point.
struct DecodedDepth {
  static constexpr float kNoPoint = -1e6f;
  std::vector<float> depth;
};

DecodedDepth decoded_depth(const VideoGroup& group, const PixelDepths& depths);

}  // namespace pointreel
