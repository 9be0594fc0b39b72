#include "client/record/frame_plan.h"

#include <vector>

namespace pointreel {

FramePlan::FramePlan(const Timeline& timeline, std::uint64_t at_us,
                     const std::optional<std::uint64_t>& duration_us, bool loop)
    : timeline_(timeline), loop_(loop), first_(timeline.frame_at(at_us)) {
  const std::uint64_t frames = timeline_.frame_count();
  if (!loop_) count_ = frames - first_;
  if (!duration_us) return;
  // The first picture that begins when the duration is over, by bisection.
  std::uint64_t low = 0;
  std::uint64_t high = count_.value_or((*duration_us / timeline_.duration_us + 2) * frames);
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
  const std::uint64_t frames = timeline_.frame_count(), ordinal = first_ + index;
  const auto frame = static_cast<std::uint32_t>(ordinal % frames);
  const std::uint64_t reel_time =
      ordinal / frames * timeline_.duration_us + timeline_.times_us[frame];
  return {frame, reel_time - timeline_.times_us[first_], reel_time};
}

std::optional<FrameRate> FramePlan::rate() const {
  std::vector<std::uint64_t> times = timeline_.times_us;
  // The next pass must begin at the same rate. A single frame lasts as long as the reel.
  if (loop_ || times.size() == 1) times.push_back(timeline_.duration_us);
  return exact_rate(times);
}

}  // namespace pointreel
