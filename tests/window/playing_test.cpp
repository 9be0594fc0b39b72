// Playing, pausing and seeking, with keys and with the mouse.

#include <algorithm>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/window/window_test.h"

namespace pointreel::window::playing_test {
namespace {

using testing::HasSubstr;

class PlayingWindow : public WindowTest {};

TEST_F(PlayingWindow, a_reel_plays_at_once_pauses_and_resumes) {
  open();
  EXPECT_THAT(player().title(), HasSubstr("plate"));
  EXPECT_TRUE(wait_for_next_frame());
  pause();
  keep("paused");
  player().key("space");
  EXPECT_TRUE(wait_for_next_frame());
  const auto report = quit();
  EXPECT_GT(report["frames_shown"], 1);
  EXPECT_EQ(report["errors"], 0);
  EXPECT_EQ(player().err(), "");
}

TEST_F(PlayingWindow, no_picture_is_a_draft_if_drafts_are_disabled) {
  open({"--drafts", "never"});
  EXPECT_TRUE(wait_for_next_frame());
  EXPECT_TRUE(wait_for_next_frame());
  const auto report = quit();
  EXPECT_GT(report["frames_shown"], 1);
  EXPECT_EQ(report["frames_reduced"], 0);
}

TEST_F(PlayingWindow, drafts_are_drawn_if_time_is_short) {
  // So many frames per second that no machine can draw each of them.
  open_sources({Stand::get().folder / "in", "--fps", "1000"});
  EXPECT_TRUE(wait_for_next_frame());
  EXPECT_TRUE(wait_for_next_frame());
  EXPECT_GT(quit()["frames_reduced"], 1);
}

TEST_F(PlayingWindow, arrow_keys_seek_by_five_seconds_while_paused) {
  open({"--at", "1"});
  pause();
  const int from = frame();
  player().key("Right");
  EXPECT_TRUE(wait_for_frame(from + 5 * MovingPlate::kFps)) << from << " to " << frame();
  player().key("Left");
  EXPECT_TRUE(wait_for_frame(from)) << from << " to " << frame();
  quit();
}

TEST_F(PlayingWindow, step_keys_show_the_next_or_previous_frame_and_pause) {
  open({"--at", "3"});
  pause();
  const int from = frame();
  player().key("period");
  EXPECT_TRUE(wait_for_frame(from + 1));
  player().key("period");
  EXPECT_TRUE(wait_for_frame(from + 2));
  player().key("comma");
  EXPECT_TRUE(wait_for_frame(from + 1));
  player().key("space");
  EXPECT_TRUE(wait_for_next_frame());
  player().key("comma");
  EXPECT_GE(paused_frame(), 0);
  quit();
}

TEST_F(PlayingWindow, other_keys_seek_by_a_second_a_minute_a_tenth_and_to_the_ends) {
  open({"--at", "5", "--no-loop"});
  pause();
  const int from = frame();
  player().key("shift+Right");
  EXPECT_TRUE(wait_for_frame(from + MovingPlate::kFps)) << from << " to " << frame();
  player().key("shift+Left");
  EXPECT_TRUE(wait_for_frame(from)) << from << " to " << frame();
  player().key("Up");
  EXPECT_TRUE(wait_for_frame(MovingPlate::kFrames - 1)) << "it must stop at the end: " << frame();
  player().key("Home");
  EXPECT_TRUE(wait_for_frame(0)) << frame();
  player().key("Prior");
  EXPECT_TRUE(wait_for_frame(MovingPlate::kFrames / 10)) << frame();
  player().key("Next");
  EXPECT_TRUE(wait_for_frame(0)) << frame();
  player().key("space");
  player().key("End");
  EXPECT_EQ(paused_frame(), MovingPlate::kFrames - 1) << "it must also pause";
  quit();
}

TEST_F(PlayingWindow, arrow_keys_stop_at_the_start_and_wrap_at_the_end_of_a_loop) {
  open({"--at", "1"});
  pause();
  player().key("Left");
  EXPECT_TRUE(wait_for_frame(0)) << frame();
  player().key("End");
  EXPECT_TRUE(wait_for_frame(MovingPlate::kFrames - 1)) << frame();
  player().key("Right");
  EXPECT_TRUE(wait_for_frame(0)) << frame();
  quit();
}

TEST_F(PlayingWindow, an_a_b_loop_repeats) {
  open({"--at", "4"});
  pause();
  const int a = frame();
  player().key("l");
  player().key("shift+Right");
  EXPECT_TRUE(wait_for_frame(a + MovingPlate::kFps));
  player().key("l");
  player().key("space");
  int least = MovingPlate::kFrames, most = -1, turns = 0, before = -1;
  EXPECT_TRUE(wait_until([&] {
    const int now = frame();
    if (now < 0) return false;
    turns += now < before;
    before = now;
    if (turns > 0) {
      least = std::min(least, now);
      most = std::max(most, now);
    }
    return turns == 3;
  }));
  EXPECT_GE(least, a);
  EXPECT_LE(most, a + MovingPlate::kFps);
  const auto report = quit();
  EXPECT_EQ(report["window"]["loop_range_s"].size(), 2u) << report["window"].dump();
}

TEST_F(PlayingWindow, keys_change_the_speed_and_the_loop) {
  open();
  for (const char* key : {"bracketright", "bracketright", "BackSpace", "braceright", "L"})
    player().key(key);
  EXPECT_TRUE(wait_for_next_frame());
  const auto report = quit();
  EXPECT_NEAR(report["window"]["speed"], 2.0, 0.01);
  EXPECT_FALSE(report["window"]["loop"].get<bool>());
}

TEST_F(PlayingWindow, dragging_with_shift_seeks_to_the_time_under_the_cursor) {
  open();
  pause();
  const glm::ivec2 size = player().size();
  player().key_down("shift");
  player().press({size.x / 4, size.y / 2});
  EXPECT_TRUE(wait_for_frame(MovingPlate::kFrames / 4)) << frame();
  player().move_to({size.x * 3 / 4, size.y / 2});
  EXPECT_TRUE(wait_for_frame(MovingPlate::kFrames * 3 / 4)) << frame();
  player().release();
  player().key_up("shift");
  EXPECT_EQ(paused_frame(), MovingPlate::kFrames * 3 / 4) << "it must stay paused";
  quit();
}

TEST_F(PlayingWindow, a_negative_speed_plays_backward) {
  open({"--at", "6", "--speed", "-1"});
  int first = -1;
  ASSERT_TRUE(wait_until([&] { return (first = frame()) >= 0; }));
  EXPECT_TRUE(wait_until([&] { return frame() >= 0 && frame() < first; }));
  quit();
}

TEST_F(PlayingWindow, playback_without_a_loop_ends_at_the_last_frame) {
  open({"--no-loop", "--at", "11"});
  EXPECT_TRUE(
      wait_until([&] { return !player().running() || frame() == MovingPlate::kFrames - 1; }));
}

TEST_F(PlayingWindow, closing_the_window_ends_the_player_cleanly) {
  open();
  EXPECT_TRUE(wait_for_next_frame());
  const auto report = player().close();
  EXPECT_EQ(player().exit_code(), 0) << player().err();
  EXPECT_FALSE(report.is_discarded());
}

}  // namespace
}  // namespace pointreel::window::playing_test
