#include "codec/video_encode/decoded_depth.h"

namespace pointreel {

DecodedDepth decoded_depth(const VideoGroup& group, const PixelDepths& depths) {
  DecodedDepth decoded;
  decoded.depth.assign(group.pixels(), DecodedDepth::kNoPoint);
  for (const Patch& patch : group.patches) {
    const DepthSteps& steps = group.depth[static_cast<std::size_t>(patch.view)];
    const float pixels = 1.0f / steps.steps;
    for (int y = patch.atlas_y; y < patch.atlas_y + patch.height; ++y) {
      const std::size_t row = group.pixel(patch.atlas_x, y);
      for (std::size_t p = row; p < row + static_cast<std::size_t>(patch.width); ++p) {
        const std::int16_t value = depths.values[p];
        if (value != PixelDepths::kNoPoint)
          decoded.depth[p] = steps.begin + pixels * static_cast<float>(value);
      }
    }
  }
  return decoded;
}

}  // namespace pointreel
