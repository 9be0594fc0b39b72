#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "codec/video/av1_decoder.h"
#include "codec/video/pixel_depths.h"
#include "codec/video/video_group.h"
#include "pointreel/executor.h"

/// Pictures of half the resolution, for views that show no more.
namespace pointreel {

struct CoarsePictures {
  VideoGroup group;  ///< with pixels twice as wide; patches begin where they were in the pictures
  PixelDepths depths;
  std::vector<std::uint8_t> samples;  ///< of colours
  std::optional<Av1Picture> colors;   ///< views of `samples`
};

/// How often pictures can be halved: patches have at least kPatchGrain rows.
inline constexpr int kMostHalvings = 3;

/// Each pixel has the mean of the two by two that it stands for, as far as they are on one surface.
/// `colors` may be null.
CoarsePictures halve(const VideoGroup& group, const PixelDepths& depths, const Av1Picture* colors,
                     const Executor& executor = {});

}  // namespace pointreel
