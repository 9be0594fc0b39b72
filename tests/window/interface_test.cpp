// The bar at the bottom, the help and the panels.

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/window/window_test.h"

namespace pointreel::window::interface_test {
namespace {

constexpr int kFrames = MovingPlate::kFrames;

class InterfaceWindow : public WindowTest {
 protected:
  /// A pixel on the timeline, which has a margin of 14 pixels on each side.
  glm::ivec2 on_timeline(double share) {
    const glm::ivec2 size = player().size();
    return {static_cast<int>(std::lround(14.0 + share * (size.x - 28.0))), size.y - 45};
  }
  /// The middle of a button below the timeline: 0 steps back, 1 plays, 2 steps forward, 3 loops.
  glm::ivec2 button(int number) {
    return {static_cast<int>(9.0 + 26.0 * (number + 0.5)), player().size().y - 18};
  }
  /// The number of pixels in these rows that differ from the upper left corner of the window.
  std::size_t drawn(int top, int bottom) {
    const e2e::Picture picture = player().picture();
    if (picture.pixels.empty()) return 0;
    return static_cast<std::size_t>(
        std::count_if(picture.pixels.begin() + std::ptrdiff_t{top} * picture.size.x,
                      picture.pixels.begin() + std::ptrdiff_t{bottom} * picture.size.x,
                      [&](const glm::u8vec3& pixel) { return pixel != picture.pixels.front(); }));
  }
  /// Moves there, waits for the bar, and presses, as a hand does.
  void press(glm::ivec2 pixel) {
    player().move_to(pixel - glm::ivec2(3, 0));
    player().move_to(pixel);
    EXPECT_TRUE(wait_until([&] { return bar() > 1000; })) << "the bar must appear";
    player().press(pixel);
  }
  std::size_t bar() { return drawn(player().size().y - 60, player().size().y); }
};

TEST_F(InterfaceWindow, the_bar_appears_when_the_mouse_moves_and_disappears_after_a_moment) {
  open();
  ASSERT_TRUE(wait_for_next_frame());
  EXPECT_TRUE(wait_until([&] { return bar() == 0; }));
  player().move_to({400, 300});
  player().move_to({410, 300});
  EXPECT_TRUE(wait_until([&] { return bar() > 1000; }));
  keep("bar");
  EXPECT_TRUE(wait_until([&] { return bar() == 0; }));
  quit();
}

TEST_F(InterfaceWindow, dragging_the_timeline_goes_to_the_time_under_the_cursor) {
  open();
  pause();
  press(on_timeline(0.25));
  EXPECT_TRUE(wait_for_frame(kFrames / 4)) << frame();
  player().move_to(on_timeline(0.755));
  EXPECT_TRUE(wait_for_frame(kFrames * 3 / 4)) << frame();
  keep("timeline dragged");
  // The timeline is still held by a cursor far above it.
  player().move_to(on_timeline(0.505) - glm::ivec2(0, 300));
  EXPECT_TRUE(wait_for_frame(kFrames / 2)) << frame();
  player().release();
  EXPECT_EQ(paused_frame(), kFrames / 2);
  const auto report = quit();
  EXPECT_EQ(report["window"]["frame"], kFrames / 2);
  EXPECT_FALSE(report["window"]["playing"].get<bool>());
}

TEST_F(InterfaceWindow, playback_resumes_from_the_end_of_a_drag) {
  open();
  ASSERT_TRUE(wait_for_next_frame());
  press(on_timeline(0.505));
  EXPECT_TRUE(wait_for_frame(kFrames / 2)) << frame();
  EXPECT_EQ(paused_frame(), kFrames / 2) << "it must pause while held";
  player().release();
  EXPECT_TRUE(wait_until([&] { return frame() > kFrames / 2; }));
  quit();
}

TEST_F(InterfaceWindow, the_buttons_act_like_their_keys) {
  open({"--at", "4"});
  ASSERT_TRUE(wait_for_next_frame());
  player().move_to(button(1));
  EXPECT_TRUE(wait_until([&] { return bar() > 1000; })) << "the bar must appear";
  player().click(button(1));
  const int from = paused_frame();
  ASSERT_GE(from, 0) << "playback must pause";
  player().click(button(2));
  EXPECT_TRUE(wait_for_frame(from + 1)) << frame();
  player().click(button(0));
  EXPECT_TRUE(wait_for_frame(from)) << frame();
  player().click(button(3));
  player().click(button(1));
  EXPECT_TRUE(wait_for_next_frame());
  EXPECT_FALSE(quit()["window"]["loop"].get<bool>());
}

TEST_F(InterfaceWindow, the_wheel_over_the_timeline_steps_through_frames_and_does_not_zoom) {
  open({"--at", "4"});
  pause();
  const int from = frame();
  player().move_to(on_timeline(0.5));
  player().scroll(3);
  EXPECT_TRUE(wait_for_frame(from + 3)) << frame();
  player().scroll(-2);
  EXPECT_TRUE(wait_for_frame(from + 1)) << frame();
  quit();
}

TEST_F(InterfaceWindow, the_question_mark_in_the_bar_opens_the_help) {
  open();
  pause();
  const glm::ivec2 size = player().size(), mark(size.x - 100, size.y - 18);
  player().move_to(mark - glm::ivec2(3, 0));
  EXPECT_TRUE(wait_until([&] { return bar() > 1000; })) << "the bar must appear";
  player().click(mark);
  EXPECT_TRUE(wait_until([&] { return drawn(0, size.y / 2) > 20'000; }));
  EXPECT_TRUE(quit()["window"]["shown"]["help"].get<bool>());
}

TEST_F(InterfaceWindow, a_click_on_the_bar_does_not_turn_the_camera) {
  open();
  pause();
  const int from = frame();
  player().drag({player().size().x / 2, player().size().y - 18},
                {player().size().x / 2 + 200, player().size().y - 18});
  EXPECT_EQ(paused_frame(), from);
  quit();
}

TEST_F(InterfaceWindow, the_timeline_shows_a_thumbnail_of_the_time_under_the_cursor) {
  open({"--at", "2"});
  pause();
  player().move_to(on_timeline(0.5));
  player().move_to(on_timeline(0.51));
  EXPECT_TRUE(wait_until([&] {
    return e2e::find_hue(player().picture(), {1, 0, 0}).pixels >
           MovingPlate::plate(player().picture()).pixels + 50;
  })) << "the thumbnail must show the plate";
  keep("thumbnail");
  quit();
}

TEST_F(InterfaceWindow, the_help_key_shows_and_hides_the_keys) {
  open();
  pause();
  const std::size_t before = drawn(0, player().size().y);
  player().key("question");
  EXPECT_TRUE(wait_until([&] { return drawn(0, player().size().y) > before + 20'000; }));
  keep("help");
  player().key("question");
  EXPECT_TRUE(wait_until([&] { return drawn(0, player().size().y) < before + 10'000; }));
  player().key("question");
  EXPECT_TRUE(wait_until([&] { return drawn(0, player().size().y) > before + 20'000; }));
  EXPECT_TRUE(quit()["window"]["shown"]["help"].get<bool>());
}

TEST_F(InterfaceWindow, a_panel_reacts_only_while_the_mouse_is_over_it) {
  open();
  pause();
  const auto panel = [this] {
    const e2e::Picture picture = player().picture();
    std::vector<glm::u8vec3> pixels;
    for (int y = 60; y < 200 && y < picture.size.y; ++y)
      for (int x = 20; x < 200 && x < picture.size.x; ++x) pixels.push_back(picture.at(x, y));
    return pixels;
  };
  const auto without = panel();
  player().key("d");
  EXPECT_TRUE(wait_until([&] { return panel() != without; }));
  const glm::ivec2 outside(500, 300), on_voxels(103, 86);
  player().move_to(outside);
  std::vector<glm::u8vec3> before;
  EXPECT_TRUE(wait_until([&] { return std::exchange(before, panel()) == before; }));
  player().move_to(on_voxels);
  EXPECT_TRUE(wait_until([&] { return panel() != before; }));
  keep("a panel under the mouse");
  player().move_to(outside);
  EXPECT_TRUE(wait_until([&] { return panel() == before; }));
  player().press(on_voxels);
  player().release();
  EXPECT_TRUE(wait_until([&] { return panel() != before; }));
  EXPECT_EQ(quit()["mode"], "voxel");
}

TEST_F(InterfaceWindow, the_interface_is_twice_as_large_at_scale_2) {
  open({"--ui-scale", "2"});
  ASSERT_TRUE(wait_for_next_frame());
  player().move_to({400, 300});
  player().move_to({410, 300});
  EXPECT_TRUE(
      wait_until([&] { return drawn(player().size().y - 130, player().size().y - 80) > 500; }));
  keep("scale 2");
  quit();
}

TEST_F(InterfaceWindow, the_s_key_saves_the_current_picture_without_the_interface) {
  open({"--at", "3"});
  pause();
  const int shown = frame();
  player().key("question");
  player().key("s");
  const auto png = folder_ / "pointreel-0001.png";
  EXPECT_TRUE(wait_until([&] { return plate().frame(e2e::read_picture(png)) == shown; }));
  quit();
}

TEST_F(InterfaceWindow, the_plus_and_minus_keys_change_the_size_of_the_interface_which_is_kept) {
  open();
  pause();
  const auto bar_rows = [&](int from, int to) {
    player().move_to({400, 300});
    player().move_to({410, 300});
    return drawn(player().size().y - to, player().size().y - from);
  };
  EXPECT_TRUE(wait_until([&] { return bar_rows(0, 60) > 1000; }));
  EXPECT_EQ(bar_rows(80, 130), bar_rows(140, 190)) << "the bar is lower than this";
  for (int i = 0; i < 4; ++i) player().key("plus");
  EXPECT_TRUE(wait_until([&] { return bar_rows(80, 130) > 500; }));
  keep("interface 200 %");
  player().key("minus");
  quit();
  open();
  pause();
  EXPECT_TRUE(wait_until([&] { return bar_rows(60, 110) > 500; })) << "it is kept";
  player().key("minus");
  for (int i = 0; i < 3; ++i) player().key("minus");
  EXPECT_TRUE(wait_until([&] { return bar_rows(75, 110) < 500; }));
  quit();
}

TEST_F(InterfaceWindow, the_interface_is_larger_on_a_4k_screen) {
  auto large = VirtualDisplay::start({3840, 2160});
  ASSERT_TRUE(large) << large.error().message;
  auto opened = PlayerWindow::open(**large, {{plate().reel()}, folder_.path(), {}});
  ASSERT_TRUE(opened) << opened.error().message;
  player_ = *std::move(opened);
  pause();
  EXPECT_TRUE(wait_until([&] {
    player().move_to({400, 300});
    player().move_to({410, 300});
    return drawn(player().size().y - 104, player().size().y - 75) > 500;
  }));
  keep("4k screen");
  quit();
}

}  // namespace
}  // namespace pointreel::window::interface_test
