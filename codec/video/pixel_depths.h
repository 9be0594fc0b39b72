#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "codec/video/av1_decoder.h"
#include "codec/video/occupancy.h"
#include "codec/video/video_group.h"
#include "pointreel/executor.h"

namespace pointreel {

/// The depth of each pixel of the pictures that has a point: values of the picture of depth, which
/// DepthSteps makes places of.
struct PixelDepths {
  static constexpr std::int16_t kNoPoint = -16384;
  std::vector<std::int16_t>
      values;  ///< 0 to 1023, or kNoPoint; outside of patches they mean nothing
  std::vector<std::size_t> points;  ///< how many each patch has
};

/// How far the depth of a neighbour on the same surface may be, in values.
int same_surface(const DepthSteps& steps);

/// Reads a decoded picture of depth. Points that fewer than three of their eight neighbours
/// support, within two pixels of depth, are left out: coding throws single pixels at the edge of a
/// patch far off the surface.
PixelDepths read_depths(const VideoGroup& group, const BlockMask& blocks,
                        const PlaneView<std::uint16_t>& picture, const Executor& executor = {});

}  // namespace pointreel
