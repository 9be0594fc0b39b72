#include "client/window/scrubbing.h"

namespace pointreel {
namespace {

constexpr std::chrono::milliseconds kAwaited{80};

}  // namespace

void Scrubbing::drag(const Input& input, Controls& controls, const SceneFrame* shown,
                     TimePoint now) {
  if (const ReelPlayback* reel = controls.reel(); reel && input.scrub) {
    if (!controls.scrubbing()) asked_.reset();
    const auto time_us = static_cast<std::uint64_t>(
        *input.scrub * static_cast<double>(reel->timeline().duration_us));
    controls.scrub_to(time_us, now);
    frame_ = reel->timeline().frame_at(time_us);
    if (shown && shown->index == frame_)
      asked_.reset();
    else if (!asked_)
      asked_ = now;
  }
  if (!input.scrubbing && controls.scrubbing()) controls.scrub_end(now);
}

void Scrubbing::show(const SceneFrame* shown, TimePoint now) {
  if (!asked_ || !shown || shown->index != frame_) return;
  times_.add(std::chrono::duration<double, std::milli>(now - *asked_).count());
  asked_.reset();
}

Scrubbing::TimePoint Scrubbing::awaited_until() const {
  return asked_ ? *asked_ + kAwaited : TimePoint{};
}

}  // namespace pointreel
