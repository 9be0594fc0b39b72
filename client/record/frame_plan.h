#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "client/playback/clock.h"
#include "client/record/frame_rate.h"

namespace pointreel {

/// The frames of a reel that are drawn if there is no clock: each one once and in order, but for
/// those that end when they begin, which a cut of video keeps to decode the others. They begin with
/// the frame shown at a time of the reel, and end at the end of the reel or after a duration. If
/// the reel loops, there is no end without a duration.
class FramePlan {
 public:
  FramePlan(const Timeline& timeline, std::uint64_t at_us,
            const std::optional<std::uint64_t>& duration_us, bool loop);

  struct Picture {
    std::uint32_t frame = 0;
    std::uint64_t time_us = 0;       ///< when the picture begins, since the first picture
    std::uint64_t reel_time_us = 0;  ///< the same since the start of the reel, passes added up
  };
  /// The number of pictures; empty if there is no end.
  std::optional<std::uint64_t> count() const { return count_; }
  Picture picture(std::uint64_t index) const;

  /// The rate at which the pictures follow each other; empty if they do so at uneven times.
  std::optional<FrameRate> rate() const;

 private:
  const std::uint64_t duration_us_;
  const bool loop_;
  std::vector<std::uint32_t> frames_;    ///< that are drawn
  std::vector<std::uint64_t> times_us_;  ///< when each of them begins
  std::uint64_t first_ = 0;              ///< of them
  std::optional<std::uint64_t> count_;
};

}  // namespace pointreel
