#include "client/playback/clock.h"

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <utility>

#include "client/web/wasm/module.h"
#include "client/web/wasm/numbers.h"

using namespace pointreel;

struct PrClock {
  Clock clock;
};

namespace {

double us_of(Clock::TimePoint time) {
  return std::chrono::duration<double, std::micro>(time.time_since_epoch()).count();
}

std::uint64_t whole(double us) { return static_cast<std::uint64_t>(std::max(us, 0.0)); }

}  // namespace

PrClock* pr_clock_new(const double* times_us, std::uint32_t count, double duration_us,
                      std::int32_t loop) {
  Timeline timeline;
  for (std::uint32_t i = 0; i < count; ++i) timeline.times_us.push_back(whole(times_us[i]));
  timeline.duration_us = whole(duration_us);
  return new PrClock{Clock(std::move(timeline), loop != 0)};
}

void pr_clock_free(PrClock* clock) { delete clock; }

const PrReading* pr_clock_read(const PrClock* clock, double now_us) {
  static PrReading answer;
  const Clock::Reading reading = clock->clock.read(time_of(now_us));
  answer = {static_cast<double>(reading.position_us), static_cast<double>(reading.frame),
            static_cast<double>(reading.ordinal), reading.ended ? 1.0 : 0.0};
  return &answer;
}

double pr_clock_next_frame(const PrClock* clock, double now_us) {
  const auto next = clock->clock.next_frame(time_of(now_us));
  return next ? us_of(*next) : -1.0;
}

const PrClockState* pr_clock_state(const PrClock* clock) {
  static PrClockState state;
  const Clock& of = clock->clock;
  state = {};
  state.playing = of.playing();
  state.held = of.held();
  state.speed = of.speed();
  state.loop = of.loop();
  if (const auto& range = of.loop_range()) {
    const FrameRange frames = of.loop_frames().value_or(FrameRange{});
    state.has_range = 1;
    state.a_us = static_cast<double>(range->a_us);
    state.b_us = static_cast<double>(range->b_us);
    state.first = frames.first;
    state.last = frames.last;
  }
  return &state;
}

std::uint32_t pr_clock_frame_at(const PrClock* clock, double time_us) {
  return clock->clock.timeline().frame_at(whole(time_us));
}

void pr_clock_play(PrClock* clock, double now_us) { clock->clock.play(time_of(now_us)); }
void pr_clock_pause(PrClock* clock, double now_us) { clock->clock.pause(time_of(now_us)); }
void pr_clock_hold(PrClock* clock, double now_us) { clock->clock.hold(time_of(now_us)); }
void pr_clock_release(PrClock* clock, double now_us) { clock->clock.release(time_of(now_us)); }

void pr_clock_seek(PrClock* clock, double time_us, double now_us) {
  clock->clock.seek(whole(time_us), time_of(now_us));
}

void pr_clock_seek_by(PrClock* clock, double delta_us, double now_us) {
  clock->clock.seek_by(static_cast<std::int64_t>(delta_us), time_of(now_us));
}

void pr_clock_step(PrClock* clock, double frames, double now_us) {
  clock->clock.step(static_cast<std::int64_t>(frames), time_of(now_us));
}

void pr_clock_set_speed(PrClock* clock, double speed, double now_us) {
  clock->clock.set_speed(speed, time_of(now_us));
}

void pr_clock_set_loop(PrClock* clock, std::int32_t loop, double now_us) {
  clock->clock.set_loop(loop != 0, time_of(now_us));
}

void pr_clock_set_loop_range(PrClock* clock, double a_us, double b_us, double now_us) {
  std::optional<LoopRange> range;
  if (a_us >= 0.0) range = LoopRange{whole(a_us), whole(b_us)};
  clock->clock.set_loop_range(range, time_of(now_us));
}
