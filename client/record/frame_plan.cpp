#include "client/record/frame_plan.h"

#include <algorithm>
#include <vector>

namespace pointreel {

FramePlan::FramePlan(const Timeline& timeline, std::uint64_t at_us,
                     const std::optional<std::uint64_t>& duration_us, bool loop)
    : duration_us_(timeline.duration_us), loop_(loop) {
  const std::vector<std::uint64_t>& times = timeline.times_us;
  for (std::uint32_t frame = 0; frame < timeline.frame_count(); ++frame) {
    if (frame + 1 < times.size() && times[frame + 1] == times[frame]) continue;
    frames_.push_back(frame);
    times_us_.push_back(times[frame]);
  }
  const auto first = std::upper_bound(times_us_.begin(), times_us_.end(), at_us);
  if (first != times_us_.begin())
    first_ = static_cast<std::uint64_t>(first - times_us_.begin() - 1);
  if (!loop_) count_ = frames_.size() - first_;
  if (!duration_us) return;
  // The first picture that begins when the duration is over, by bisection.
  std::uint64_t low = 0;
  std::uint64_t high = count_.value_or((*duration_us / duration_us_ + 2) * frames_.size());
  while (low < high) {
    const std::uint64_t middle = low + (high - low) / 2;
    if (picture(middle).time_us < *duration_us) {
      low = middle + 1;
    } else {
      high = middle;
    }
  }
  count_ = low;
}

FramePlan::Picture FramePlan::picture(std::uint64_t index) const {
  const std::uint64_t ordinal = first_ + index, at = ordinal % frames_.size();
  const std::uint64_t reel_time = ordinal / frames_.size() * duration_us_ + times_us_[at];
  return {frames_[at], reel_time - times_us_[first_], reel_time};
}

std::optional<FrameRate> FramePlan::rate() const {
  std::vector<std::uint64_t> times = times_us_;
  // The next pass must begin at the same rate. A single frame lasts as long as the reel.
  if (loop_ || times.size() == 1) times.push_back(duration_us_);
  return exact_rate(times);
}

}  // namespace pointreel
