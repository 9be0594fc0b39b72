#include "client/playback/clock.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace pointreel {
namespace {

std::int64_t floor_mod(std::int64_t a, std::int64_t n) { return ((a % n) + n) % n; }

}  // namespace

std::uint32_t Timeline::frame_at(std::uint64_t time_us) const {
  const auto after = std::upper_bound(times_us.begin(), times_us.end(), time_us);
  return after == times_us.begin() ? 0 : static_cast<std::uint32_t>(after - times_us.begin() - 1);
}

std::uint32_t Timeline::shown_number(std::uint64_t time_us) const {
  const std::uint32_t frame = frame_at(time_us);
  if (shown.empty()) return frame + 1;
  const auto after = std::upper_bound(shown.begin(), shown.end(), frame);
  return std::max<std::uint32_t>(1, static_cast<std::uint32_t>(after - shown.begin()));
}

std::uint32_t Timeline::shown_count() const {
  return shown.empty() ? frame_count() : static_cast<std::uint32_t>(shown.size());
}

Clock::Clock(Timeline timeline, bool loop) : timeline_(std::move(timeline)), loop_(loop) {}

bool Clock::before_far_end() const {
  return range_ && base_.us <= static_cast<std::int64_t>(range_->b_us);
}

bool Clock::after_near_end() const {
  return range_ && base_.us >= static_cast<std::int64_t>(range_->a_us);
}

std::optional<Clock::Lap> Clock::lap(bool in_range) const {
  if (in_range) {
    const FrameRange frames = *loop_frames();
    return Lap{static_cast<std::int64_t>(range_->a_us), static_cast<std::int64_t>(range_->b_us),
               std::int64_t{frames.last} - frames.first + 1};
  }
  if (!loop_) return std::nullopt;
  return Lap{0, static_cast<std::int64_t>(timeline_.duration_us), timeline_.frame_count()};
}

/// The place after playing on by this much of the reel's time, which is more than 0.
Clock::Place Clock::forward(std::int64_t by_us) const {
  const auto duration = static_cast<std::int64_t>(timeline_.duration_us);
  Place at = base_;
  bool in_range = before_far_end();
  if (range_ && !in_range && loop_) {
    if (at.us + by_us < duration) return {at.us + by_us, at.passed};
    by_us -= duration - at.us;
    at = {0, at.passed + timeline_.frame_count()};
    in_range = true;
  }
  const auto round = lap(in_range);
  if (!round || at.us + by_us < round->end) return {at.us + by_us, at.passed};
  const std::int64_t past = at.us + by_us - round->end, length = round->end - round->begin;
  return {round->begin + past % length, at.passed + (past / length + 1) * round->frames};
}

/// The same backward. The last microsecond before an end belongs to the frame before it.
Clock::Place Clock::backward(std::int64_t by_us) const {
  const auto duration = static_cast<std::int64_t>(timeline_.duration_us);
  Place at = base_;
  bool in_range = after_near_end();
  if (range_ && !in_range && loop_) {
    if (by_us <= at.us) return {at.us - by_us, at.passed};
    by_us -= at.us + 1;
    at = {duration - 1, at.passed - timeline_.frame_count()};
    in_range = true;
  }
  const auto round = lap(in_range);
  if (!round || at.us - by_us >= round->begin) return {at.us - by_us, at.passed};
  const std::int64_t past = round->begin - (at.us - by_us) - 1, length = round->end - round->begin;
  return {round->end - 1 - past % length, at.passed - (past / length + 1) * round->frames};
}

Clock::Place Clock::place(TimePoint now) const {
  if (!playing_ || held_) return base_;
  const double elapsed_us = std::chrono::duration<double, std::micro>(now - base_now_).count();
  const std::int64_t by_us = std::llround(std::max(0.0, elapsed_us) * std::abs(speed_));
  if (by_us == 0) return base_;
  return direction() > 0 ? forward(by_us) : backward(by_us);
}

Clock::Reading Clock::read(TimePoint now) const {
  const auto duration = static_cast<std::int64_t>(timeline_.duration_us);
  const Place at = place(now);
  Reading reading;
  if (!loop_) reading.ended = direction() > 0 ? at.us >= duration : at.us < 0;
  reading.position_us = static_cast<std::uint64_t>(std::clamp<std::int64_t>(at.us, 0, duration));
  reading.frame = timeline_.frame_at(reading.position_us);
  reading.ordinal = at.passed + reading.frame;
  return reading;
}

std::optional<Clock::TimePoint> Clock::next_frame(TimePoint now) const {
  const Reading at = read(now);
  if (!playing_ || held_ || at.ended) return std::nullopt;
  const std::uint32_t next = at.frame + 1;
  std::uint64_t left_us = 0;  // of the reel's time
  if (direction() > 0) {
    std::uint64_t end =
        next < timeline_.frame_count() ? timeline_.times_us[next] : timeline_.duration_us;
    if (range_ && at.position_us <= range_->b_us) end = std::min(end, range_->b_us);
    left_us = std::max<std::uint64_t>(1, end - at.position_us);
  } else {
    std::uint64_t begin = timeline_.times_us[at.frame];
    if (range_ && at.position_us >= range_->a_us) begin = std::max(begin, range_->a_us);
    left_us = at.position_us - std::min(begin, at.position_us) + 1;
  }
  const auto left =
      std::chrono::duration<double, std::micro>(static_cast<double>(left_us) / std::abs(speed_));
  return now + std::chrono::ceil<std::chrono::microseconds>(left);
}

void Clock::restart_at(std::uint64_t position_us, TimePoint now) {
  base_ = {static_cast<std::int64_t>(position_us), 0};
  base_now_ = now;
}

void Clock::rebase(TimePoint now) {
  base_ = place(now);
  base_now_ = now;
}

void Clock::play(TimePoint now) {
  if (playing_) return;
  const auto last = static_cast<std::int64_t>(timeline_.duration_us) - 1;
  rebase(now);
  const bool goes_on = loop_ || (direction() > 0 ? before_far_end() : after_near_end());
  if (!goes_on && direction() > 0 && base_.us > last) base_.us = 0;
  if (!goes_on && direction() < 0 && base_.us <= 0) base_.us = last;
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
  const bool begins_anew = loop_ && target >= duration;
  seek(begins_anew ? 0 : static_cast<std::uint64_t>(std::max<std::int64_t>(target, 0)), now);
}

void Clock::step(std::int64_t frames, TimePoint now) {
  pause(now);
  const std::int64_t count = timeline_.frame_count();
  const std::int64_t target = static_cast<std::int64_t>(read(now).frame) + frames;
  const std::vector<std::uint64_t>& times = timeline_.times_us;
  auto frame = static_cast<std::size_t>(loop_ ? floor_mod(target, count)
                                              : std::clamp<std::int64_t>(target, 0, count - 1));
  // Frames that the next one replaces at the same time are not shown: going there leads to the last
  // of them, which may be where we are.
  while (frames < 0 && frame + 1 < times.size() && times[frame] == times[frame + 1]) {
    if (frame == 0 && !loop_) break;
    frame = frame == 0 ? times.size() - 1 : frame - 1;
  }
  seek(times[frame], now);
}

void Clock::set_speed(double speed, TimePoint now) {
  rebase(now);
  // Playback that has gone past an end turns around at the end.
  if (!loop_)
    base_.us =
        std::clamp<std::int64_t>(base_.us, 0, static_cast<std::int64_t>(timeline_.duration_us));
  speed_ = std::copysign(std::clamp(std::abs(speed), kMinSpeed, kMaxSpeed), speed);
}

void Clock::set_loop(bool loop, TimePoint now) {
  restart_at(read(now).position_us, now);
  loop_ = loop;
}

void Clock::set_loop_range(const std::optional<LoopRange>& range, TimePoint now) {
  restart_at(read(now).position_us, now);
  range_ = range;
  if (!range_) return;
  if (range_->a_us > range_->b_us) std::swap(range_->a_us, range_->b_us);
  range_->a_us = std::min(range_->a_us, timeline_.duration_us - 1);
  range_->b_us = std::min(range_->b_us, timeline_.duration_us);
  if (range_->b_us > range_->a_us) return;
  const std::uint32_t frame = timeline_.frame_at(range_->a_us);
  range_->a_us = std::min(range_->a_us, timeline_.times_us[frame]);
  range_->b_us =
      frame + 1 < timeline_.frame_count() ? timeline_.times_us[frame + 1] : timeline_.duration_us;
}

Clock Clock::without_frames() const {
  Clock copy({{0}, timeline_.duration_us}, loop_);
  copy.playing_ = playing_;
  copy.held_ = held_;
  copy.speed_ = speed_;
  copy.range_ = range_;
  copy.base_ = {base_.us, 0};
  copy.base_now_ = base_now_;
  return copy;
}

std::optional<FrameRange> Clock::loop_frames() const {
  if (!range_) return std::nullopt;
  return FrameRange{timeline_.frame_at(range_->a_us), timeline_.frame_at(range_->b_us - 1)};
}

}  // namespace pointreel
