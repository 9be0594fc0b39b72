#include "client/sound/null_device.h"

#include <algorithm>
#include <cmath>

namespace pointreel {

Result<AudioDevice::State> NullDevice::state(TimePoint now) {
  State state;
  if (last_ && waiting_ > 0.0) {
    waiting_ -= std::chrono::duration<double>(now - *last_).count() * pace_ * kAudioRate;
    state.broken_off = waiting_ < 0.0;
    waiting_ = std::max(waiting_, 0.0);
  }
  last_ = now;
  state.room = kBuffer - std::min(kBuffer, static_cast<std::size_t>(std::ceil(waiting_)));
  state.delay = waiting_ + static_cast<double>(latency_);
  return state;
}

Result<void> NullDevice::write(std::span<const StereoSample> samples) {
  waiting_ += static_cast<double>(samples.size());
  return {};
}

}  // namespace pointreel
