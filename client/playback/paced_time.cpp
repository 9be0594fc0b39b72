#include "client/playback/paced_time.h"

#include <algorithm>

namespace pointreel {

PacedTime::TimePoint PacedTime::value(TimePoint now) const {
  if (pace_ == 1.0) return base_ + (now - base_now_);
  const std::chrono::duration<double, std::nano> passed = now - base_now_;
  return base_ + std::chrono::round<TimePoint::duration>(pace_ * passed);
}

PacedTime::TimePoint PacedTime::at(TimePoint now) const {
  const std::lock_guard lock(mutex_);
  last_ = std::max(last_, value(now));
  return last_;
}

void PacedTime::set_pace(double pace, TimePoint now) {
  base_ = value(now);
  base_now_ = now;
  pace_ = pace;
}

void PacedTime::follow(TimePoint target, TimePoint now) {
  const std::lock_guard lock(mutex_);
  const double error = std::chrono::duration<double>(target - value(now)).count();
  set_pace(1.0 + std::clamp(error / kCorrection, -kMostOff, kMostOff), now);
}

void PacedTime::let_go(TimePoint now) {
  const std::lock_guard lock(mutex_);
  set_pace(1.0, now);
}

}  // namespace pointreel
