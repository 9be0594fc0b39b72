#include "client/playback/clock.h"

#include <cmath>

#include <gtest/gtest.h>

namespace pointreel::clock_test {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;

constexpr Clock::TimePoint kStart{std::chrono::hours(5)};

/// Ten frames of 100 ms.
Timeline ten_frames() {
  Timeline timeline;
  for (std::uint64_t i = 0; i < 10; ++i) timeline.times_us.push_back(i * 100'000);
  timeline.duration_us = 1'000'000;
  return timeline;
}

TEST(Timeline, gives_the_last_frame_that_has_begun) {
  const Timeline timeline = ten_frames();
  EXPECT_EQ(timeline.frame_at(0), 0u);
  EXPECT_EQ(timeline.frame_at(99'999), 0u);
  EXPECT_EQ(timeline.frame_at(100'000), 1u);
  EXPECT_EQ(timeline.frame_at(5'000'000), 9u);
}

TEST(Timeline, gives_the_first_frame_for_times_before_it) {
  EXPECT_EQ((Timeline{{50, 100}, 200}.frame_at(10)), 0u);
}

TEST(Timeline, gives_the_last_of_several_frames_at_the_same_time) {
  EXPECT_EQ((Timeline{{0, 50, 50, 90}, 100}.frame_at(50)), 2u);
  EXPECT_EQ((Timeline{{0, 50, 50, 90}, 100}.shown_number(50)), 3u);
  EXPECT_EQ((Timeline{{0, 50, 50, 90}, 100, {0, 2, 3}}.shown_number(50)), 2u);
  EXPECT_EQ((Timeline{{0, 50, 50, 90}, 100, {0, 2, 3}}.shown_count()), 3u);
}

TEST(Clock, stays_at_the_start_until_it_plays) {
  const Clock clock(ten_frames(), true);
  EXPECT_FALSE(clock.playing());
  EXPECT_EQ(clock.read(kStart + milliseconds(350)).frame, 0u);
}

TEST(Clock, shows_each_frame_for_its_own_duration) {
  Clock clock(ten_frames(), true);
  clock.play(kStart);
  for (int i = 0; i < 10; ++i) {
    EXPECT_EQ(clock.read(kStart + milliseconds(100 * i)).frame, i);
    EXPECT_EQ(clock.read(kStart + milliseconds(100 * i + 99)).frame, i);
  }
}

TEST(Clock, wraps_at_the_end_of_a_loop_and_keeps_counting_frames) {
  Clock clock(ten_frames(), true);
  clock.play(kStart);
  const auto last = clock.read(kStart + milliseconds(999));
  const auto first = clock.read(kStart + milliseconds(1000));
  EXPECT_EQ(last.frame, 9u);
  EXPECT_EQ(first.frame, 0u);
  EXPECT_EQ(first.position_us, 0u);
  EXPECT_EQ(first.ordinal - last.ordinal, 1);
  EXPECT_FALSE(first.ended);
  EXPECT_EQ(clock.read(kStart + milliseconds(7250)).position_us, 250'000u);
  EXPECT_EQ(clock.read(kStart + milliseconds(7250)).ordinal, 72);
}

TEST(Clock, ends_after_the_duration_of_the_last_frame_without_a_loop) {
  Clock clock(ten_frames(), false);
  clock.play(kStart);
  EXPECT_FALSE(clock.read(kStart + milliseconds(999)).ended);
  const auto end = clock.read(kStart + milliseconds(1000));
  EXPECT_TRUE(end.ended);
  EXPECT_EQ(end.frame, 9u);
  EXPECT_EQ(end.position_us, 1'000'000u);
  EXPECT_EQ(clock.read(kStart + milliseconds(90'000)).frame, 9u);
}

TEST(Clock, starts_over_when_played_from_the_end) {
  Clock clock(ten_frames(), false);
  clock.play(kStart);
  clock.pause(kStart + milliseconds(1500));
  clock.play(kStart + milliseconds(2000));
  EXPECT_EQ(clock.read(kStart + milliseconds(2150)).frame, 1u);
}

TEST(Clock, does_not_advance_while_paused) {
  Clock clock(ten_frames(), true);
  clock.play(kStart);
  clock.pause(kStart + milliseconds(250));
  EXPECT_EQ(clock.read(kStart + milliseconds(9999)).position_us, 250'000u);
  clock.play(kStart + milliseconds(10'000));
  EXPECT_EQ(clock.read(kStart + milliseconds(10'100)).position_us, 350'000u);
}

TEST(Clock, seeks_backward_while_playing) {
  Clock clock(ten_frames(), false);
  clock.play(kStart);
  clock.seek(100'000, kStart + milliseconds(800));
  EXPECT_EQ(clock.read(kStart + milliseconds(800)).frame, 1u);
  EXPECT_EQ(clock.read(kStart + milliseconds(1050)).frame, 3u);
}

TEST(Clock, a_relative_seek_stops_at_the_ends_or_wraps_in_a_loop) {
  Clock looping(ten_frames(), true), once(ten_frames(), false);
  for (Clock* clock : {&looping, &once}) {
    clock->seek_by(250'000, kStart);
    EXPECT_EQ(clock->read(kStart).position_us, 250'000u);
    clock->seek_by(-5'000'000, kStart);
    EXPECT_EQ(clock->read(kStart).position_us, 0u);
    clock->seek_by(999'999, kStart);
    EXPECT_EQ(clock->read(kStart).position_us, 999'999u);
    clock->seek_by(5'000'000, kStart);
  }
  EXPECT_EQ(looping.read(kStart).position_us, 0u);
  EXPECT_EQ(once.read(kStart).position_us, 999'999u);
  EXPECT_EQ(once.read(kStart).frame, 9u);
  EXPECT_FALSE(once.read(kStart).ended);
}

TEST(Clock, a_step_goes_to_the_exact_time_of_the_next_frame_and_pauses) {
  Clock clock(ten_frames(), false);
  clock.play(kStart);
  clock.step(1, kStart + milliseconds(130));
  EXPECT_FALSE(clock.playing());
  EXPECT_EQ(clock.read(kStart + milliseconds(900)).position_us, 200'000u);
  clock.step(-1, kStart + milliseconds(900));
  clock.step(-1, kStart + milliseconds(900));
  clock.step(-1, kStart + milliseconds(900));
  EXPECT_EQ(clock.read(kStart + milliseconds(900)).position_us, 0u);
}

TEST(Clock, a_step_back_passes_frames_that_are_not_shown) {
  Clock clock({{0, 0, 100, 200, 200, 200, 300}, 400}, true);
  clock.seek(300, kStart);
  clock.step(-1, kStart);
  EXPECT_EQ(clock.read(kStart).frame, 5u);
  clock.step(-1, kStart);
  EXPECT_EQ(clock.read(kStart).frame, 2u);
  clock.step(-1, kStart);
  EXPECT_EQ(clock.read(kStart).frame, 1u);
  clock.step(-1, kStart);
  EXPECT_EQ(clock.read(kStart).frame, 6u);
  clock.seek(100, kStart);
  clock.step(1, kStart);
  EXPECT_EQ(clock.read(kStart).frame, 5u);
}

TEST(Clock, a_step_wraps_at_the_ends_of_a_loop) {
  Clock clock(ten_frames(), true);
  clock.step(-1, kStart);
  EXPECT_EQ(clock.read(kStart).frame, 9u);
  clock.step(1, kStart);
  EXPECT_EQ(clock.read(kStart).frame, 0u);
}

TEST(Clock, does_not_jump_when_the_speed_changes) {
  Clock clock(ten_frames(), true);
  clock.play(kStart);
  clock.set_speed(2.0, kStart + milliseconds(300));
  EXPECT_EQ(clock.read(kStart + milliseconds(300)).position_us, 300'000u);
  EXPECT_EQ(clock.read(kStart + milliseconds(400)).position_us, 500'000u);
  clock.set_speed(0.5, kStart + milliseconds(400));
  EXPECT_EQ(clock.read(kStart + milliseconds(500)).position_us, 550'000u);
}

TEST(Clock, clamps_the_speed) {
  Clock clock(ten_frames(), true);
  clock.set_speed(100.0, kStart);
  EXPECT_EQ(clock.speed(), kMaxSpeed);
  clock.set_speed(0.0, kStart);
  EXPECT_EQ(clock.speed(), kMinSpeed);
  clock.set_speed(-0.01, kStart);
  EXPECT_EQ(clock.speed(), -kMinSpeed);
  clock.set_speed(-9.0, kStart);
  EXPECT_EQ(clock.speed(), -kMaxSpeed);
}

TEST(Clock, shows_each_frame_for_its_own_duration_when_played_backward) {
  Clock clock(ten_frames(), false);
  clock.seek(999'999, kStart);
  clock.set_speed(-1.0, kStart);
  clock.play(kStart);
  for (int i = 0; i < 10; ++i) {
    EXPECT_EQ(clock.read(kStart + milliseconds(100 * i)).frame, 9 - i);
    EXPECT_EQ(clock.read(kStart + milliseconds(100 * i + 99)).frame, 9 - i);
  }
}

TEST(Clock, wraps_at_the_start_of_a_loop_when_played_backward_and_counts_down) {
  Clock clock(ten_frames(), true);
  clock.set_speed(-1.0, kStart);
  clock.play(kStart);
  const auto first = clock.read(kStart);
  const auto last = clock.read(kStart + milliseconds(1));
  EXPECT_EQ(first.frame, 0u);
  EXPECT_EQ(last.frame, 9u);
  EXPECT_EQ(last.position_us, 999'000u);
  EXPECT_EQ(last.ordinal - first.ordinal, -1);
  EXPECT_FALSE(last.ended);
  EXPECT_EQ(clock.read(kStart + milliseconds(7250)).position_us, 750'000u);
  EXPECT_EQ(clock.read(kStart + milliseconds(7250)).ordinal, -73);
}

TEST(Clock, ends_at_the_start_when_played_backward_and_restarts_from_the_end) {
  Clock clock(ten_frames(), false);
  clock.seek(200'000, kStart);
  clock.set_speed(-1.0, kStart);
  clock.play(kStart);
  EXPECT_FALSE(clock.read(kStart + milliseconds(200)).ended);
  const auto end = clock.read(kStart + milliseconds(201));
  EXPECT_TRUE(end.ended);
  EXPECT_EQ(end.frame, 0u);
  EXPECT_EQ(end.position_us, 0u);
  clock.pause(kStart + milliseconds(300));
  clock.play(kStart + milliseconds(400));
  EXPECT_EQ(clock.read(kStart + milliseconds(450)).frame, 9u);
  EXPECT_FALSE(clock.read(kStart + milliseconds(450)).ended);
}

TEST(Clock, reverses_without_a_jump_even_after_the_end) {
  Clock clock(ten_frames(), false);
  clock.play(kStart);
  clock.set_speed(-2.0, kStart + milliseconds(500));
  EXPECT_EQ(clock.read(kStart + milliseconds(500)).position_us, 500'000u);
  EXPECT_EQ(clock.read(kStart + milliseconds(600)).position_us, 300'000u);
  clock.set_speed(1.0, kStart + milliseconds(9000));
  EXPECT_EQ(clock.read(kStart + milliseconds(9100)).position_us, 100'000u);
}

TEST(Clock, keeps_to_every_allowed_speed_in_both_directions) {
  for (const double speed : {0.1, 0.5, 1.0, 2.5, 4.0, -0.1, -1.5, -4.0}) {
    Clock clock(ten_frames(), true);
    clock.seek(500'000, kStart);
    clock.set_speed(speed, kStart);
    clock.play(kStart);
    const auto expected = static_cast<std::uint64_t>(std::llround(500'000 + 100'000 * speed));
    EXPECT_EQ(clock.read(kStart + milliseconds(100)).position_us, expected) << speed;
  }
}

TEST(Clock, stands_still_while_held_and_resumes_from_there) {
  Clock clock(ten_frames(), true);
  clock.play(kStart);
  clock.hold(kStart + milliseconds(250));
  EXPECT_TRUE(clock.playing());
  EXPECT_EQ(clock.read(kStart + milliseconds(9999)).position_us, 250'000u);
  clock.hold(kStart + milliseconds(9999));
  clock.release(kStart + milliseconds(10'000));
  EXPECT_EQ(clock.read(kStart + milliseconds(10'100)).position_us, 350'000u);
  clock.release(kStart + milliseconds(10'100));
  EXPECT_EQ(clock.read(kStart + milliseconds(10'200)).position_us, 450'000u);
}

TEST(Clock, keeps_its_position_when_the_loop_is_switched_off_in_a_later_pass) {
  Clock clock(ten_frames(), true);
  clock.play(kStart);
  clock.set_loop(false, kStart + milliseconds(2400));
  EXPECT_EQ(clock.read(kStart + milliseconds(2500)).position_us, 500'000u);
  EXPECT_TRUE(clock.read(kStart + milliseconds(3100)).ended);
}

TEST(Clock, plays_a_reel_of_one_frame) {
  Clock clock(Timeline{{0}, 33'333}, true);
  clock.play(kStart);
  EXPECT_EQ(clock.read(kStart + milliseconds(500)).frame, 0u);
  clock.step(-1, kStart + milliseconds(500));
  EXPECT_EQ(clock.read(kStart + milliseconds(500)).frame, 0u);
}

TEST(ClockRange, repeats_whether_or_not_the_reel_loops) {
  for (const bool loop : {false, true}) {
    Clock clock(ten_frames(), loop);
    clock.set_loop_range(LoopRange{300'000, 500'000}, kStart);
    clock.play(kStart);
    EXPECT_EQ(clock.read(kStart + milliseconds(499)).position_us, 499'000u) << "enters the range";
    for (int pass = 1; pass < 20; ++pass) {
      const auto begin = kStart + milliseconds(300 + 200 * pass);
      EXPECT_EQ(clock.read(begin).position_us, 300'000u);
      EXPECT_EQ(clock.read(begin + milliseconds(199)).position_us, 499'000u);
      EXPECT_FALSE(clock.read(begin).ended);
      EXPECT_EQ(clock.read(begin).ordinal, 3 + 2 * pass);
    }
  }
}

TEST(ClockRange, repeats_when_played_backward) {
  for (const bool loop : {false, true}) {
    Clock clock(ten_frames(), loop);
    clock.set_loop_range(LoopRange{300'000, 500'000}, kStart);
    clock.seek(450'000, kStart);
    clock.set_speed(-2.0, kStart);
    clock.play(kStart);
    EXPECT_EQ(clock.read(kStart + milliseconds(75)).position_us, 300'000u);
    EXPECT_EQ(clock.read(kStart + milliseconds(75)).frame, 3u);
    EXPECT_EQ(clock.read(kStart + milliseconds(80)).position_us, 490'000u);
    EXPECT_EQ(clock.read(kStart + milliseconds(80)).ordinal, 2);
    EXPECT_EQ(clock.read(kStart + milliseconds(180)).position_us, 490'000u);
  }
}

TEST(ClockRange, does_not_capture_playback_that_seeks_past_it_until_the_reel_wraps) {
  Clock looping(ten_frames(), true), once(ten_frames(), false);
  for (Clock* clock : {&looping, &once}) {
    clock->set_loop_range(LoopRange{300'000, 500'000}, kStart);
    clock->play(kStart);
    clock->seek(800'000, kStart);
    EXPECT_EQ(clock->read(kStart + milliseconds(199)).position_us, 999'000u);
  }
  EXPECT_TRUE(once.read(kStart + milliseconds(200)).ended);
  EXPECT_EQ(looping.read(kStart + milliseconds(200)).position_us, 0u);
  EXPECT_EQ(looping.read(kStart + milliseconds(200)).ordinal, 10);
  EXPECT_EQ(looping.read(kStart + milliseconds(699)).position_us, 499'000u);
  EXPECT_EQ(looping.read(kStart + milliseconds(700)).position_us, 300'000u);
  EXPECT_EQ(looping.read(kStart + milliseconds(700)).ordinal, 15);
}

TEST(ClockRange, wraps_at_once_if_its_far_end_is_set_to_the_current_position) {
  Clock clock(ten_frames(), false);
  clock.play(kStart);
  clock.set_loop_range(LoopRange{200'000, 730'000}, kStart + milliseconds(730));
  EXPECT_EQ(clock.read(kStart + milliseconds(740)).position_us, 210'000u);
}

TEST(ClockRange, does_not_move_a_paused_clock) {
  Clock clock(ten_frames(), true);
  clock.seek(730'000, kStart);
  clock.set_loop_range(LoopRange{200'000, 730'000}, kStart);
  EXPECT_EQ(clock.read(kStart + milliseconds(500)).position_us, 730'000u);
  clock.step(1, kStart);
  EXPECT_EQ(clock.read(kStart).frame, 8u);
  clock.seek(100'000, kStart);
  clock.step(-1, kStart);
  EXPECT_EQ(clock.read(kStart).frame, 0u);
}

TEST(ClockRange, accepts_its_ends_in_any_order_and_clamps_them_to_the_reel) {
  Clock clock(ten_frames(), true);
  clock.set_loop_range(LoopRange{9'000'000, 200'000}, kStart);
  EXPECT_EQ(clock.loop_range(), (LoopRange{200'000, 1'000'000}));
  EXPECT_EQ(clock.loop_frames(), (FrameRange{2, 9}));
  clock.set_loop_range(LoopRange{250'000, 300'001}, kStart);
  EXPECT_EQ(clock.loop_frames(), (FrameRange{2, 3}));
  clock.set_loop_range(LoopRange{250'000, 300'000}, kStart);
  EXPECT_EQ(clock.loop_frames(), (FrameRange{2, 2}));
}

TEST(ClockRange, covers_one_frame_if_both_ends_are_equal) {
  Clock clock(ten_frames(), true);
  clock.set_loop_range(LoopRange{350'000, 350'000}, kStart);
  EXPECT_EQ(clock.loop_range(), (LoopRange{300'000, 400'000}));
  clock.set_loop_range(LoopRange{5'000'000, 6'000'000}, kStart);
  EXPECT_EQ(clock.loop_range(), (LoopRange{999'999, 1'000'000}));
  clock.set_loop_range(std::nullopt, kStart);
  EXPECT_FALSE(clock.loop_range());
  EXPECT_FALSE(clock.loop_frames());
}

TEST(ClockRange, may_extend_to_the_ends_of_the_reel_in_either_direction) {
  Clock clock(ten_frames(), false);
  clock.set_loop_range(LoopRange{0, 1'000'000}, kStart);
  clock.play(kStart);
  EXPECT_EQ(clock.read(kStart + milliseconds(1250)).position_us, 250'000u);
  EXPECT_FALSE(clock.read(kStart + milliseconds(1250)).ended);
  clock.pause(kStart);
  clock.seek(0, kStart);
  clock.set_speed(-1.0, kStart);
  clock.play(kStart);
  EXPECT_EQ(clock.read(kStart + milliseconds(1)).position_us, 999'000u);
}

TEST(ClockRange, keeps_counting_frames_across_pauses_and_changes_of_speed) {
  Clock clock(ten_frames(), true);
  clock.set_loop_range(LoopRange{300'000, 500'000}, kStart);
  clock.play(kStart);
  const auto before = clock.read(kStart + milliseconds(1050));
  clock.hold(kStart + milliseconds(1050));
  clock.release(kStart + milliseconds(2000));
  clock.set_speed(2.0, kStart + milliseconds(2000));
  EXPECT_EQ(clock.read(kStart + milliseconds(2000)).ordinal, before.ordinal);
  EXPECT_EQ(clock.read(kStart + milliseconds(2000)).position_us, before.position_us);
  EXPECT_EQ(clock.read(kStart + milliseconds(2050)).ordinal, before.ordinal + 1);
}

/// A position that advances microsecond by microsecond.
class Walker {
 public:
  Walker(const Timeline& timeline, bool loop, int direction, const std::optional<LoopRange>& range,
         std::int64_t start)
      : timeline_(timeline), loop_(loop), direction_(direction), range_(range), at_(start) {
    ordinal_ = frame();
  }
  void step() {
    const auto duration = static_cast<std::int64_t>(timeline_.duration_us);
    const std::int64_t before = frame();
    if (ended_) return;
    if (direction_ > 0) {
      const bool in_range = range_ && at_ < b();
      ++at_;
      if (in_range && at_ == b())
        at_ = a(), again_ = true;
      else if (at_ == duration && loop_)
        at_ = 0, again_ = true;
      else if (at_ == duration)
        ended_ = true;
    } else {
      if (range_ && at_ == a())
        at_ = b() - 1, again_ = true;
      else if (at_ > 0)
        --at_;
      else if (loop_)
        at_ = duration - 1, again_ = true;
      else
        ended_ = true;
    }
    if (again_ || frame() != before) ordinal_ += direction_ * (again_ ? 1 : apart(before));
    again_ = false;
  }
  std::int64_t at() const { return at_; }
  bool ended() const { return ended_; }
  std::int64_t frame() const { return timeline_.frame_at(static_cast<std::uint64_t>(at_)); }
  std::int64_t ordinal() const { return ordinal_; }

 private:
  std::int64_t a() const { return static_cast<std::int64_t>(range_->a_us); }
  std::int64_t b() const { return static_cast<std::int64_t>(range_->b_us); }
  std::int64_t apart(std::int64_t before) const { return std::abs(frame() - before); }

  const Timeline& timeline_;
  const bool loop_;
  const int direction_;
  const std::optional<LoopRange> range_;
  std::int64_t at_, ordinal_ = 0;
  bool ended_ = false, again_ = false;
};

TEST(Clock, knows_when_the_next_frame_begins) {
  Clock clock(ten_frames(), true);
  EXPECT_FALSE(clock.next_frame(kStart)) << "it does not play";
  clock.play(kStart);
  EXPECT_EQ(clock.next_frame(kStart), kStart + milliseconds(100));
  EXPECT_EQ(clock.next_frame(kStart + milliseconds(130)), kStart + milliseconds(200));
  clock.set_speed(2.0, kStart);
  EXPECT_EQ(clock.next_frame(kStart), kStart + milliseconds(50));
  clock.hold(kStart);
  EXPECT_FALSE(clock.next_frame(kStart)) << "it stands still";
}

TEST(Clock, shows_no_other_frame_before_the_next_one_is_due) {
  const Timeline timeline{{0, 3000, 4000, 8000}, 10000};
  const microseconds little(5);  // more than what is rounded
  for (const std::optional<LoopRange>& range :
       {std::optional<LoopRange>(), std::optional(LoopRange{2000, 7000})})
    for (const double speed : {1.0, -1.0, 0.4, -3.0})
      for (std::uint64_t start = 0; start < 10'000; start += 1000) {
        Clock clock(timeline, true);
        clock.set_loop_range(range, kStart);
        clock.set_speed(speed, kStart);
        clock.seek(start, kStart);
        clock.play(kStart);
        auto now = kStart;
        for (int i = 0; i < 20; ++i) {
          const auto due = clock.next_frame(now);
          ASSERT_TRUE(due && *due > now);
          const auto ordinal = clock.read(now).ordinal;
          EXPECT_EQ(clock.read(std::max(now, *due - little)).ordinal, ordinal)
              << "from " << start << " at " << speed << (range ? " in a range" : "");
          now = *due + little;
          if (!range) {
            EXPECT_NE(clock.read(now).ordinal, ordinal);
          }
        }
      }
}

TEST(ClockRange, agrees_with_playing_step_by_step_from_every_start_in_every_range) {
  const Timeline timeline{{0, 3, 4, 8}, 10};
  for (std::uint64_t a = 0; a < 10; ++a)
    for (std::uint64_t b = a + 1; b <= 10; ++b)
      for (const bool loop : {false, true})
        for (const int direction : {1, -1})
          for (std::uint64_t start = 0; start < 10; ++start) {
            if (direction > 0 && start == b) continue;  // tested above
            Clock clock(timeline, loop);
            clock.set_loop_range(LoopRange{a, b}, kStart);
            clock.set_speed(direction, kStart);
            clock.seek(start, kStart);
            clock.play(kStart);
            // At the end, playback begins again.
            const std::uint64_t begun = clock.read(kStart).position_us;
            Walker walker(timeline, loop, direction, LoopRange{a, b},
                          static_cast<std::int64_t>(begun));
            for (int t = 0; t < 35 && !walker.ended(); ++t, walker.step()) {
              const auto reading = clock.read(kStart + microseconds(t));
              ASSERT_EQ(static_cast<std::int64_t>(reading.position_us), walker.at())
                  << a << '-' << b << " loop " << loop << " from " << start << " at " << t << " to "
                  << direction;
              ASSERT_EQ(reading.frame, walker.frame());
              ASSERT_EQ(reading.ordinal, walker.ordinal())
                  << a << '-' << b << " loop " << loop << " from " << start << " at " << t << " to "
                  << direction;
              ASSERT_FALSE(reading.ended);
            }
          }
}

}  // namespace
}  // namespace pointreel::clock_test
