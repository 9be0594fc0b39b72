#pragma once

#include <cstdint>
#include <vector>

#include "codec/video/video_group.h"

namespace pointreel {

/// A plane of numbers, of which some are known.
struct Plane {
  int width = 0, height = 0;
  std::vector<float> values;
  std::vector<std::uint8_t> known;

  Plane(int w, int h)
      : width(w),
        height(h),
        values(static_cast<std::size_t>(w) * static_cast<std::size_t>(h)),
        known(values.size()) {}
  std::size_t at(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
           static_cast<std::size_t>(x);
  }
};

/// Continues each patch of a picture of depth by a few pixels, along the plane of the known ones
/// around them, so that coding blurs its outline less. `jump`: how far the values of one surface
/// may be apart there.
void continue_patches(const VideoGroup& group, float jump, Plane& plane);

/// Fills what is not known in the patches so that it costs few bits: from coarser and coarser means
/// of what is known around it (Pfister et al., section 7, "Image Reconstruction": pull and push).
/// `background`: what is taken, with little weight; null for nothing. `next`: the plane of the next
/// frame, or null; what is known only there is taken as it is, so that what appears has been coded
/// before it is seen. Patches are smaller by `divisor` in this plane.
void fill_patches(const VideoGroup& group, int divisor, const Plane* background, const Plane* next,
                  Plane& plane);

}  // namespace pointreel
