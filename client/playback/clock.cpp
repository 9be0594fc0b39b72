#include "client/playback/clock.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace pointreel {
namespace {

std::int64_t floor_mod(std::int64_t a, std::int64_t n) { return ((a % n) + n) % n; }
std::int64_t floor_div(std::int64_t a, std::int64_t n) { return (a - floor_mod(a, n)) / n; }

}  // namespace

std::uint32_t Timeline::frame_at(std::uint64_t time_us) const {
  const auto after = std::upper_bound(times_us.begin(), times_us.end(), time_us);
  return after == times_us.begin() ? 0 : static_cast<std::uint32_t>(after - times_us.begin() - 1);
}

Clock::Clock(Timeline timeline, bool loop) : timeline_(std::move(timeline)), loop_(loop) {}

std::int64_t Clock::unwrapped(TimePoint now) const {
  if (!playing_ || held_) return base_us_;
  const double elapsed_us = std::chrono::duration<double, std::micro>(now - base_now_).count();
  return base_us_ + std::llround(std::max(0.0, elapsed_us) * speed_);
}

Clock::Reading Clock::read(TimePoint now) const {
  const auto duration = static_cast<std::int64_t>(timeline_.duration_us);
  const std::int64_t time = unwrapped(now);
  Reading reading;
  std::int64_t pass = 0;
  if (loop_) {
    pass = floor_div(time, duration);
    reading.position_us = static_cast<std::uint64_t>(floor_mod(time, duration));
  } else {
    reading.ended = direction() > 0 ? time >= duration : time < 0;
    reading.position_us = static_cast<std::uint64_t>(std::clamp<std::int64_t>(time, 0, duration));
  }
  reading.frame = timeline_.frame_at(reading.position_us);
  reading.ordinal = pass * timeline_.frame_count() + reading.frame;
  return reading;
}

void Clock::restart_at(std::uint64_t position_us, TimePoint now) {
  base_us_ = static_cast<std::int64_t>(position_us);
  base_now_ = now;
}

void Clock::rebase(TimePoint now) {
  base_us_ = unwrapped(now);
  base_now_ = now;
}

void Clock::play(TimePoint now) {
  if (playing_) return;
  const auto last = static_cast<std::int64_t>(timeline_.duration_us) - 1;
  rebase(now);
  if (!loop_ && direction() > 0 && base_us_ > last) base_us_ = 0;
  if (!loop_ && direction() < 0 && base_us_ <= 0) base_us_ = last;
  playing_ = true;
}

void Clock::pause(TimePoint now) {
  rebase(now);
  playing_ = false;
}

void Clock::hold(TimePoint now) {
  rebase(now);
  held_ = true;
}

void Clock::release(TimePoint now) {
  rebase(now);
  held_ = false;
}

void Clock::seek(std::uint64_t time_us, TimePoint now) {
  restart_at(std::min(time_us, timeline_.duration_us - 1), now);
}

void Clock::seek_by(std::int64_t delta_us, TimePoint now) {
  const auto duration = static_cast<std::int64_t>(timeline_.duration_us);
  const std::int64_t target = static_cast<std::int64_t>(read(now).position_us) + delta_us;
  seek(static_cast<std::uint64_t>(loop_ ? floor_mod(target, duration)
                                        : std::max<std::int64_t>(target, 0)),
       now);
}

void Clock::step(std::int64_t frames, TimePoint now) {
  pause(now);
  const std::int64_t count = timeline_.frame_count();
  const std::int64_t target = static_cast<std::int64_t>(read(now).frame) + frames;
  const std::int64_t frame =
      loop_ ? floor_mod(target, count) : std::clamp<std::int64_t>(target, 0, count - 1);
  seek(timeline_.times_us[static_cast<std::size_t>(frame)], now);
}

void Clock::set_speed(double speed, TimePoint now) {
  rebase(now);
  // What is past an end counts as the end for who turns around there.
  if (!loop_)
    base_us_ =
        std::clamp<std::int64_t>(base_us_, 0, static_cast<std::int64_t>(timeline_.duration_us));
  speed_ = std::copysign(std::clamp(std::abs(speed), kMinSpeed, kMaxSpeed), speed);
}

void Clock::set_loop(bool loop, TimePoint now) {
  restart_at(read(now).position_us, now);
  loop_ = loop;
}

}  // namespace pointreel
