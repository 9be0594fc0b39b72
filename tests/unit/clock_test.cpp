#include "client/playback/clock.h"

#include <cmath>

#include <gtest/gtest.h>

namespace pointreel {
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

TEST(Timeline, GivesTheLastFrameThatHasBegun) {
  const Timeline timeline = ten_frames();
  EXPECT_EQ(timeline.frame_at(0), 0u);
  EXPECT_EQ(timeline.frame_at(99'999), 0u);
  EXPECT_EQ(timeline.frame_at(100'000), 1u);
  EXPECT_EQ(timeline.frame_at(5'000'000), 9u);
}

TEST(Timeline, GivesTheFirstFrameBeforeIt) {
  EXPECT_EQ((Timeline{{50, 100}, 200}.frame_at(10)), 0u);
}

TEST(Timeline, GivesTheLastOfFramesAtTheSameTime) {
  EXPECT_EQ((Timeline{{0, 50, 50, 90}, 100}.frame_at(50)), 2u);
}

TEST(Clock, StandsAtTheStartUntilItPlays) {
  const Clock clock(ten_frames(), true);
  EXPECT_FALSE(clock.playing());
  EXPECT_EQ(clock.read(kStart + milliseconds(350)).frame, 0u);
}

TEST(Clock, ShowsEachFrameForItsOwnTime) {
  Clock clock(ten_frames(), true);
  clock.play(kStart);
  for (int i = 0; i < 10; ++i) {
    EXPECT_EQ(clock.read(kStart + milliseconds(100 * i)).frame, i);
    EXPECT_EQ(clock.read(kStart + milliseconds(100 * i + 99)).frame, i);
  }
}

TEST(Clock, WrapsAtTheEndOfALoopAndCountsOn) {
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

TEST(Clock, EndsAfterTheLastFramesOwnDurationWithoutLoop) {
  Clock clock(ten_frames(), false);
  clock.play(kStart);
  EXPECT_FALSE(clock.read(kStart + milliseconds(999)).ended);
  const auto end = clock.read(kStart + milliseconds(1000));
  EXPECT_TRUE(end.ended);
  EXPECT_EQ(end.frame, 9u);
  EXPECT_EQ(end.position_us, 1'000'000u);
  EXPECT_EQ(clock.read(kStart + milliseconds(90'000)).frame, 9u);
}

TEST(Clock, BeginsAnewWhenPlayedFromTheEnd) {
  Clock clock(ten_frames(), false);
  clock.play(kStart);
  clock.pause(kStart + milliseconds(1500));
  clock.play(kStart + milliseconds(2000));
  EXPECT_EQ(clock.read(kStart + milliseconds(2150)).frame, 1u);
}

TEST(Clock, StandsStillWhilePaused) {
  Clock clock(ten_frames(), true);
  clock.play(kStart);
  clock.pause(kStart + milliseconds(250));
  EXPECT_EQ(clock.read(kStart + milliseconds(9999)).position_us, 250'000u);
  clock.play(kStart + milliseconds(10'000));
  EXPECT_EQ(clock.read(kStart + milliseconds(10'100)).position_us, 350'000u);
}

TEST(Clock, SeeksBackwardWhilePlaying) {
  Clock clock(ten_frames(), false);
  clock.play(kStart);
  clock.seek(100'000, kStart + milliseconds(800));
  EXPECT_EQ(clock.read(kStart + milliseconds(800)).frame, 1u);
  EXPECT_EQ(clock.read(kStart + milliseconds(1050)).frame, 3u);
}

TEST(Clock, SeekingByWrapsWhenLoopingAndClampsOtherwise) {
  Clock looping(ten_frames(), true), once(ten_frames(), false);
  looping.seek_by(-250'000, kStart);
  once.seek_by(-250'000, kStart);
  EXPECT_EQ(looping.read(kStart).position_us, 750'000u);
  EXPECT_EQ(once.read(kStart).position_us, 0u);
  looping.seek_by(500'000, kStart);
  once.seek_by(5'000'000, kStart);
  EXPECT_EQ(looping.read(kStart).position_us, 250'000u);
  EXPECT_EQ(once.read(kStart).frame, 9u);
  EXPECT_FALSE(once.read(kStart).ended);
}

TEST(Clock, StepsToTheExactTimeOfTheNextFrameAndPauses) {
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

TEST(Clock, StepsAcrossTheEndsOfALoop) {
  Clock clock(ten_frames(), true);
  clock.step(-1, kStart);
  EXPECT_EQ(clock.read(kStart).frame, 9u);
  clock.step(1, kStart);
  EXPECT_EQ(clock.read(kStart).frame, 0u);
}

TEST(Clock, DoesNotJumpWhenTheSpeedChanges) {
  Clock clock(ten_frames(), true);
  clock.play(kStart);
  clock.set_speed(2.0, kStart + milliseconds(300));
  EXPECT_EQ(clock.read(kStart + milliseconds(300)).position_us, 300'000u);
  EXPECT_EQ(clock.read(kStart + milliseconds(400)).position_us, 500'000u);
  clock.set_speed(0.5, kStart + milliseconds(400));
  EXPECT_EQ(clock.read(kStart + milliseconds(500)).position_us, 550'000u);
}

TEST(Clock, BoundsTheSpeed) {
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

TEST(Clock, PlaysBackwardAndShowsEachFrameForItsOwnTime) {
  Clock clock(ten_frames(), false);
  clock.seek(999'999, kStart);
  clock.set_speed(-1.0, kStart);
  clock.play(kStart);
  for (int i = 0; i < 10; ++i) {
    EXPECT_EQ(clock.read(kStart + milliseconds(100 * i)).frame, 9 - i);
    EXPECT_EQ(clock.read(kStart + milliseconds(100 * i + 99)).frame, 9 - i);
  }
}

TEST(Clock, WrapsAtTheStartOfALoopInBackwardPlayAndCountsDown) {
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

TEST(Clock, EndsAtTheStartInBackwardPlayWithoutLoopAndBeginsAnewAtTheEnd) {
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

TEST(Clock, TurnsAroundWithoutAJumpAlsoPastAnEnd) {
  Clock clock(ten_frames(), false);
  clock.play(kStart);
  clock.set_speed(-2.0, kStart + milliseconds(500));
  EXPECT_EQ(clock.read(kStart + milliseconds(500)).position_us, 500'000u);
  EXPECT_EQ(clock.read(kStart + milliseconds(600)).position_us, 300'000u);
  clock.set_speed(1.0, kStart + milliseconds(9000));
  EXPECT_EQ(clock.read(kStart + milliseconds(9100)).position_us, 100'000u);
}

TEST(Clock, KeepsToEverySpeedAllowedInBothDirections) {
  for (const double speed : {0.1, 0.5, 1.0, 2.5, 4.0, -0.1, -1.5, -4.0}) {
    Clock clock(ten_frames(), true);
    clock.seek(500'000, kStart);
    clock.set_speed(speed, kStart);
    clock.play(kStart);
    const auto expected = static_cast<std::uint64_t>(std::llround(500'000 + 100'000 * speed));
    EXPECT_EQ(clock.read(kStart + milliseconds(100)).position_us, expected) << speed;
  }
}

TEST(Clock, StandsStillWhileHeldAndGoesOnFromThere) {
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

TEST(Clock, KeepsThePositionWhenTheLoopIsSwitchedOffInALaterPass) {
  Clock clock(ten_frames(), true);
  clock.play(kStart);
  clock.set_loop(false, kStart + milliseconds(2400));
  EXPECT_EQ(clock.read(kStart + milliseconds(2500)).position_us, 500'000u);
  EXPECT_TRUE(clock.read(kStart + milliseconds(3100)).ended);
}

TEST(Clock, PlaysAReelOfOneFrame) {
  Clock clock(Timeline{{0}, 33'333}, true);
  clock.play(kStart);
  EXPECT_EQ(clock.read(kStart + milliseconds(500)).frame, 0u);
  clock.step(-1, kStart + milliseconds(500));
  EXPECT_EQ(clock.read(kStart + milliseconds(500)).frame, 0u);
}

}  // namespace
}  // namespace pointreel
