#pragma once

#include <cstdint>
#include <optional>

#include "client/playback/clock.h"
#include "client/record/frame_rate.h"

namespace pointreel {

/// Which frames of a reel are drawn without a clock: each once, in order, from the one that is seen
/// at a time of the reel on, to the reel's end or, going through it again and again, without one;
/// or for a duration.
class FramePlan {
 public:
  FramePlan(const Timeline& timeline, std::uint64_t at_us,
            const std::optional<std::uint64_t>& duration_us, bool loop);

  struct Picture {
    std::uint32_t frame = 0;
    std::uint64_t time_us = 0;       ///< when it begins, since the first picture
    std::uint64_t reel_time_us = 0;  ///< since the start of the first pass
  };
  /// None where there is no end.
  std::optional<std::uint64_t> count() const { return count_; }
  Picture picture(std::uint64_t index) const;

  /// That of all pictures, if they come at one.
  std::optional<FrameRate> rate() const;

 private:
  const Timeline timeline_;
  const bool loop_;
  const std::uint32_t first_;
  std::optional<std::uint64_t> count_;
};

}  // namespace pointreel
