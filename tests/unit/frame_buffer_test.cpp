#include <atomic>
#include <random>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "client/playback/buffer.h"

namespace pointreel {
namespace {

using std::chrono::milliseconds;

std::shared_ptr<const SceneFrame> picture(std::uint32_t index) {
  auto frame = std::make_shared<SceneFrame>();
  frame->index = index;
  return frame;
}

FrameBuffer::Options options(std::uint32_t frames, std::uint32_t ahead, bool loop) {
  return {frames, ahead, loop, DrawMode::surfel};
}

/// Answers `count` requests and says for which frames they were.
std::vector<std::uint32_t> serve(FrameBuffer& buffer, int count) {
  std::vector<std::uint32_t> frames;
  for (int i = 0; i < count; ++i) {
    const auto request = buffer.next_wanted();
    frames.push_back(request->frame);
    buffer.deliver(*request, picture(request->frame));
  }
  return frames;
}

using Frames = std::vector<std::uint32_t>;

TEST(FrameBuffer, AsksForThePlayheadFirstAndThenAhead) {
  FrameBuffer buffer(options(100, 3, false));
  EXPECT_EQ(serve(buffer, 4), (Frames{0, 1, 2, 3}));
  EXPECT_EQ(buffer.best()->index, 0u);
}

TEST(FrameBuffer, AsksForNothingMoreThanItsWindow) {
  FrameBuffer buffer(options(100, 2, false));
  serve(buffer, 3);
  std::atomic<bool> asked{false};
  std::thread worker([&] {
    if (buffer.next_wanted()) asked = true;
  });
  std::this_thread::sleep_for(milliseconds(10));
  EXPECT_FALSE(asked);
  buffer.advance(1);
  worker.join();
  EXPECT_TRUE(asked);
}

TEST(FrameBuffer, GoesOnAtTheStartWhenLooping) {
  FrameBuffer buffer(options(10, 3, true));
  buffer.seek(8);
  EXPECT_EQ(serve(buffer, 4), (Frames{8, 9, 0, 1}));
}

TEST(FrameBuffer, StopsAtTheEndOtherwise) {
  FrameBuffer buffer(options(10, 3, false));
  buffer.seek(8);
  EXPECT_EQ(serve(buffer, 2), (Frames{8, 9}));
  EXPECT_EQ(buffer.held(), 2u);
}

TEST(FrameBuffer, LooksBackwardWhenSeekingBackward) {
  FrameBuffer buffer(options(10, 3, false));
  buffer.seek(5, -1);
  EXPECT_EQ(serve(buffer, 4), (Frames{5, 4, 3, 2}));
  buffer.seek(1, -1);
  EXPECT_EQ(serve(buffer, 2), (Frames{1, 0}));
}

TEST(FrameBuffer, DoesNotMakeAFrameTwiceInAReelShorterThanTheWindow) {
  FrameBuffer buffer(options(3, 8, true));
  EXPECT_EQ(serve(buffer, 3), (Frames{0, 1, 2}));
  for (std::uint32_t pass = 0; pass < 5; ++pass)
    for (std::uint32_t f = 0; f < 3; ++f) {
      buffer.advance(f);
      ASSERT_EQ(buffer.best()->index, f);
    }
}

TEST(FrameBuffer, AsksForTheNewPlaceFirstAfterASeek) {
  FrameBuffer buffer(options(1000, 4, false));
  const auto old_request = buffer.next_wanted();
  buffer.seek(500);
  EXPECT_EQ(buffer.next_wanted()->frame, 500u);
  EXPECT_FALSE(buffer.wanted(*old_request));
}

TEST(FrameBuffer, DropsWhatComesFromBeforeASeek) {
  FrameBuffer buffer(options(1000, 4, false));
  serve(buffer, 2);
  const auto old_request = buffer.next_wanted();
  buffer.seek(500);
  EXPECT_EQ(buffer.best(), nullptr);
  buffer.deliver(*old_request, picture(old_request->frame));
  EXPECT_EQ(buffer.best(), nullptr);
  EXPECT_EQ(buffer.held(), 0u);
}

TEST(FrameBuffer, UsesWhatComesFromBeforeASeekIfItIsInTheNewWindow) {
  FrameBuffer buffer(options(1000, 4, false));
  serve(buffer, 2);
  const auto request = buffer.next_wanted();  // frame 2
  buffer.seek(2);
  EXPECT_TRUE(buffer.wanted(*request));
  buffer.deliver(*request, picture(2));
  EXPECT_EQ(buffer.best()->index, 2u);
}

TEST(FrameBuffer, ShowsALateFrameOnAMachineThatIsTooSlowButNeverGoesBack) {
  FrameBuffer buffer(options(1000, 4, false));
  const auto first = buffer.next_wanted();
  const auto second = buffer.next_wanted();
  buffer.advance(30);
  EXPECT_TRUE(buffer.late(*first));
  EXPECT_TRUE(buffer.wanted(*second));
  buffer.deliver(*second, picture(1));
  EXPECT_EQ(buffer.best()->index, 1u);
  buffer.deliver(*first, picture(0));
  EXPECT_EQ(buffer.best()->index, 1u);
}

TEST(FrameBuffer, HoldsTheLastFrameWhileTheNextOneIsMissing) {
  FrameBuffer buffer(options(1000, 4, false));
  serve(buffer, 3);
  buffer.advance(10);
  EXPECT_EQ(buffer.best()->index, 2u);
}

TEST(FrameBuffer, HoldsTheLastFrameAcrossTheEndOfALoop) {
  FrameBuffer buffer(options(10, 2, true));
  buffer.seek(7);
  serve(buffer, 3);
  buffer.advance(9);
  buffer.advance(0);
  EXPECT_EQ(buffer.best()->index, 9u);
  buffer.advance(1);
  EXPECT_EQ(buffer.best()->index, 9u);
  EXPECT_EQ(serve(buffer, 1), (Frames{1}));
  EXPECT_EQ(buffer.best()->index, 1u);
}

TEST(FrameBuffer, GoesOnAfterAFrameThatFails) {
  FrameBuffer buffer(options(100, 2, false));
  serve(buffer, 1);
  const auto broken = buffer.next_wanted();
  buffer.fail(*broken);
  EXPECT_EQ(buffer.next_wanted()->frame, 2u);
  buffer.advance(1);
  EXPECT_EQ(buffer.wait(milliseconds(0)), FrameBuffer::State::failed);
  EXPECT_EQ(buffer.best()->index, 0u) << "the last picture is held";
}

TEST(FrameBuffer, AsksAgainForAnAbandonedFrame) {
  FrameBuffer buffer(options(100, 2, false));
  const auto request = buffer.next_wanted();
  buffer.abandon(*request);
  EXPECT_EQ(buffer.next_wanted()->frame, 0u);
}

TEST(FrameBuffer, DropsEverythingMadeForAnotherMode) {
  FrameBuffer buffer(options(100, 2, false));
  serve(buffer, 1);
  const auto old_request = buffer.next_wanted();
  buffer.set_mode(DrawMode::voxel);
  buffer.set_mode(DrawMode::surfel);
  EXPECT_EQ(buffer.best(), nullptr);
  const auto request = buffer.next_wanted();
  EXPECT_EQ(request->frame, 0u);
  EXPECT_EQ(buffer.next_wanted()->frame, 1u);
  EXPECT_FALSE(buffer.wanted(*old_request));
  buffer.deliver(*old_request, picture(1));
  EXPECT_EQ(buffer.held(), 0u);
}

TEST(FrameBuffer, DoesNotShowTheStartBehindTheEndWhenTheLoopIsSwitchedOff) {
  FrameBuffer buffer(options(10, 3, true));
  buffer.seek(8);
  const auto eight = buffer.next_wanted();
  serve(buffer, 3);  // 9, 0, 1
  buffer.set_loop(false);
  EXPECT_EQ(buffer.held(), 1u);
  EXPECT_EQ(buffer.best(), nullptr);
  buffer.deliver(*eight, picture(8));
  EXPECT_EQ(buffer.best()->index, 8u);
}

TEST(FrameBuffer, ClosingEndsTheWaitOfAWorkerAndOfThePlayer) {
  FrameBuffer buffer(options(1, 0, true));
  serve(buffer, 1);
  std::thread worker([&] { EXPECT_EQ(buffer.next_wanted(), std::nullopt); });
  FrameBuffer starved(options(1, 0, true));
  std::thread player(
      [&] { EXPECT_EQ(starved.wait(milliseconds(60'000)), FrameBuffer::State::closed); });
  buffer.close();
  starved.close();
  worker.join();
  player.join();
}

TEST(FrameBuffer, StaysBoundedAndNeverShowsTheWrongFrameUnderRandomSeeks) {
  constexpr std::uint32_t kFrames = 50, kAhead = 5;
  FrameBuffer buffer(options(kFrames, kAhead, true));
  std::vector<std::thread> workers;
  for (int t = 0; t < 3; ++t)
    workers.emplace_back([&, t] {
      std::mt19937 random(static_cast<unsigned>(t));
      while (const auto request = buffer.next_wanted()) {
        if (random() % 4 == 0)
          std::this_thread::sleep_for(std::chrono::microseconds(random() % 300));
        if (!buffer.wanted(*request)) {
          buffer.abandon(*request);
        } else if (random() % 10 == 0) {
          buffer.fail(*request);
        } else {
          buffer.deliver(*request, picture(request->frame));
        }
      }
    });
  std::mt19937 random(99);
  std::uint32_t playhead = 0;
  for (int i = 0; i < 3000; ++i) {
    const bool jump = random() % 10 == 0;
    playhead = jump ? static_cast<std::uint32_t>(random() % kFrames) : (playhead + 1) % kFrames;
    if (jump)
      buffer.seek(playhead);
    else
      buffer.advance(playhead);
    if (i % 3 == 0) {
      const auto state = buffer.wait(milliseconds(2000));
      ASSERT_NE(state, FrameBuffer::State::waiting);
      if (state == FrameBuffer::State::ready) {
        ASSERT_EQ(buffer.best()->index, playhead);
      }
    }
    ASSERT_LE(buffer.held(), kAhead + 2);
  }
  buffer.close();
  for (std::thread& worker : workers) worker.join();
}

std::shared_ptr<const SceneFrame> picture_at(std::uint32_t index, int level) {
  auto frame = std::make_shared<SceneFrame>();
  frame->index = index;
  frame->level = level;
  return frame;
}

TEST(FrameBuffer, AsksAgainForFramesThatLackALevelOnlyWhenNoneIsMissing) {
  FrameBuffer buffer(options(100, 2, false));
  buffer.set_level(7);
  const auto answer = [&] {
    const auto request = buffer.next_wanted();
    buffer.deliver(*request, picture_at(request->frame, request->level));
    return std::pair{request->frame, request->level};
  };
  EXPECT_EQ(answer(), (std::pair{0u, 7}));
  buffer.set_level(9);
  EXPECT_EQ(answer(), (std::pair{1u, 9}));
  EXPECT_EQ(answer(), (std::pair{2u, 9}));
  EXPECT_EQ(buffer.wait(milliseconds(0)), FrameBuffer::State::ready);
  EXPECT_EQ(buffer.wait(milliseconds(0), true), FrameBuffer::State::waiting);
  EXPECT_EQ(answer(), (std::pair{0u, 9}));
  EXPECT_EQ(buffer.wait(milliseconds(0), true), FrameBuffer::State::ready);
  EXPECT_EQ(buffer.best()->level, 9);
  EXPECT_EQ(buffer.held(), 3u);
}

TEST(FrameBuffer, KeepsWhatIsFinerWhenTheCameraMovesAway) {
  FrameBuffer buffer(options(100, 1, false));
  for (int i = 0; i < 2; ++i) {
    const auto request = buffer.next_wanted();
    buffer.deliver(*request, picture_at(request->frame, 9));
  }
  EXPECT_EQ(buffer.best()->level, 9);
  buffer.set_level(6);
  EXPECT_EQ(buffer.best()->level, 9);
  buffer.advance(1);
  const auto request = buffer.next_wanted();
  EXPECT_EQ(request->frame, 2u);
  EXPECT_EQ(request->level, 6);
  EXPECT_EQ(buffer.best()->level, 9);
}

TEST(FrameBuffer, AsksForALevelThatCannotBeHadOnlyOnce) {
  for (const bool broken : {false, true}) {
    FrameBuffer buffer(options(1, 0, false));
    buffer.set_level(7);
    auto request = buffer.next_wanted();
    buffer.deliver(*request, picture_at(0, 7));
    buffer.set_level(10);
    request = buffer.next_wanted();
    EXPECT_EQ(request->level, 10);
    EXPECT_TRUE(buffer.wanted(*request));
    if (broken)
      buffer.fail(*request);
    else
      buffer.deliver(*request, picture_at(0, 7));
    EXPECT_EQ(buffer.wait(milliseconds(0), true), FrameBuffer::State::ready);
    ASSERT_NE(buffer.best(), nullptr) << "what was there stays";
    std::thread closer([&] {
      std::this_thread::sleep_for(milliseconds(5));
      buffer.close();
    });
    EXPECT_FALSE(buffer.next_wanted());
    closer.join();
  }
}

}  // namespace
}  // namespace pointreel
