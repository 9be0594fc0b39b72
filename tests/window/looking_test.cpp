// The drawing modes, the camera and the size of the window.

#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/window/window_test.h"

namespace pointreel::window::looking_test {
namespace {

class LookingWindow : public WindowTest {
 protected:
  /// The number of pixels of the plate, relative to `first`.
  double times(const e2e::Patch& first) {
    return static_cast<double>(patch().pixels) / static_cast<double>(first.pixels);
  }
  e2e::Patch patch() { return MovingPlate::plate(player().picture()); }
};

TEST_F(LookingWindow, the_m_key_cycles_through_all_modes) {
  for (const auto& [times, mode] :
       {std::pair{1, "voxel"}, {2, "point"}, {3, "strip"}, {4, "surfel"}}) {
    open({"--mode", "surfel"});  // the player remembers the last mode
    pause();
    const e2e::Picture before = player().picture();
    for (int i = 0; i < times; ++i) player().key("m");
    if (times < 4) {
      EXPECT_TRUE(wait_until([&] { return player().picture().pixels != before.pixels; }));
    }
    keep(mode);
    EXPECT_EQ(quit()["mode"], mode);
  }
}

TEST_F(LookingWindow, the_mouse_turns_moves_and_zooms_and_the_0_key_resets) {
  open({"--at", "6"});
  pause();
  const int from = frame();
  const glm::ivec2 middle = player().size() / 2;
  const auto first = patch();

  player().drag(middle, middle + glm::ivec2(150, 0));
  EXPECT_TRUE(wait_until([&] { return times(first) < 0.95; })) << "the camera must turn";
  player().key("0");
  EXPECT_TRUE(wait_for_frame(from));

  player().drag(middle, middle + glm::ivec2(120, 40), 3);
  EXPECT_TRUE(wait_until([&] {
    const glm::dvec2 moved = patch().center - first.center;
    return std::abs(moved.x - 120) < 12 && std::abs(moved.y - 40) < 12;
  })) << patch().center.x - first.center.x;
  player().key("0");
  EXPECT_TRUE(wait_for_frame(from));

  player().move_to(middle);
  player().scroll(3);
  EXPECT_TRUE(wait_until([&] { return times(first) > 1.4; })) << "the camera must come nearer";
  player().scroll(-3);
  EXPECT_TRUE(wait_until([&] { return times(first) < 1.1; })) << "the camera must move away";
  quit();
}

TEST_F(LookingWindow, a_view_turned_there_and_back_looks_as_before) {
  open({"--at", "6"});
  pause();
  const e2e::Picture before = player().picture();
  const glm::ivec2 middle = player().size() / 2;
  const auto as_before = [&] {
    const e2e::Picture now = player().picture();
    std::size_t other = 0;
    for (std::size_t i = 0; i < now.pixels.size(); ++i) other += now.pixels[i] != before.pixels[i];
    return other * 1000 < now.pixels.size();
  };
  // However coarse the picture was while the mouse moved.
  player().press(middle);
  player().move_to(middle + glm::ivec2(40, 0));
  EXPECT_TRUE(wait_until([&] { return !as_before(); }));
  player().move_to(middle);
  player().release();
  player().move_to({player().size().x / 2, 0});
  EXPECT_TRUE(wait_until(as_before));
  quit();
}

TEST_F(LookingWindow, a_double_click_centres_the_point_under_the_cursor) {
  open({"--at", "3"});
  pause();
  const auto first = patch();
  ASSERT_GT(std::abs(first.center.x - player().size().x / 2), 100);
  // The rows of the patch begin at a quarter of the picture's height.
  player().double_click(glm::ivec2(first.center) + glm::ivec2(0, player().size().y / 4));
  EXPECT_TRUE(wait_until([&] { return std::abs(patch().center.x - player().size().x / 2) < 10; }))
      << patch().center.x;
  quit();
}

TEST_F(LookingWindow, the_wheel_zooms_towards_the_point_under_the_cursor) {
  open({"--at", "3"});
  pause();
  const auto first = patch();
  player().move_to(glm::ivec2(first.center) + glm::ivec2(0, player().size().y / 4));
  player().scroll(2);
  EXPECT_TRUE(wait_until([&] { return times(first) > 1.2; }));
  EXPECT_NEAR(patch().center.x, first.center.x, 12);
  quit();
}

TEST_F(LookingWindow, the_w_and_d_keys_fly_forward_and_right) {
  open({"--at", "6"});
  pause();
  const int from = frame();
  const auto first = patch();
  player().key("Tab");
  player().key_down("w");
  EXPECT_TRUE(wait_until([&] { return times(first) > 1.3; })) << "the camera must fly forward";
  player().key_up("w");
  player().key_down("d");
  EXPECT_TRUE(wait_until([&] { return patch().center.x < first.center.x - 60; })) << "to the right";
  player().key_up("d");
  player().key("0");
  EXPECT_TRUE(wait_for_frame(from));
  // Before Tab, q would fly down, also if both keys come before the player looks at the first.
  display().xdotool({"key", "--delay", "0", "Tab", "q"});
  EXPECT_TRUE(wait_until([&] { return !player().running(); }));
  quit();
}

TEST_F(LookingWindow, the_g_key_shows_a_grid_on_the_floor) {
  open();
  pause();
  const e2e::Picture before = player().picture();
  player().key("g");
  EXPECT_TRUE(wait_until([&] {
    const e2e::Picture now = player().picture();
    std::size_t changed = 0;
    for (std::size_t i = 0; i < now.pixels.size() && i < before.pixels.size(); ++i)
      changed += now.pixels[i] != before.pixels[i];
    return changed > 5000;
  }));
  keep("floor");
  EXPECT_TRUE(quit()["window"]["floor"].get<bool>());
}

TEST_F(LookingWindow, a_resized_window_shows_the_same_frame) {
  open({"--at", "4"});
  pause();
  const int from = frame();
  // The whole reel is visible at either size, so the plate changes its place.
  for (const glm::ivec2 size : {glm::ivec2(800, 600), glm::ivec2(1500, 500)}) {
    player().resize(size);
    EXPECT_TRUE(wait_until([&] { return player().size() == size && patch().pixels > 500; }))
        << size.x << ": " << patch().pixels;
  }
  keep("resized");
  const auto report = quit();
  EXPECT_EQ(report["size"], nlohmann::json({1500, 500}));
  // The requested frame may have arrived after the previous one was looked at.
  EXPECT_NEAR(report["window"]["frame"].get<int>(), from, 2);
}

TEST_F(LookingWindow, a_narrow_window_shows_the_whole_scene_until_the_camera_is_moved) {
  open({"--at", "6"});
  pause();
  const auto first = patch();
  player().resize({420, 700});
  // For a moment there is nothing in the window.
  const auto smaller = [&] { return times(first) > 0.01 && times(first) < 0.6; };
  EXPECT_TRUE(wait_until(smaller)) << times(first);
  keep("narrow");
  const auto narrow = patch();
  player().move_to(player().size() / 2);
  player().scroll(1);
  const auto nearer = [&] { return times(narrow) > 1.15 && times(narrow) < 1.5; };
  EXPECT_TRUE(wait_until(nearer)) << times(narrow);
  const auto before = patch();
  player().resize({1200, 700});
  const auto as_near = [&] { return std::abs(times(before) - 1.0) < 0.15; };
  EXPECT_TRUE(wait_until([&] { return player().size().x == 1200 && as_near(); })) << times(before);
  quit();
}

TEST_F(LookingWindow, the_f_key_fills_the_screen_and_escape_restores_the_window) {
  open({"--at", "4"});
  pause();
  const glm::ivec2 before = player().size();
  player().key("f");
  EXPECT_TRUE(wait_until([&] { return player().size() == glm::ivec2(1600, 1000); }));
  EXPECT_TRUE(wait_until([&] { return frame() >= 0; }));
  player().key("Escape");
  EXPECT_TRUE(wait_until([&] { return player().size() == before; }));
  EXPECT_TRUE(player().running());
  quit();
}

TEST_F(LookingWindow, the_number_keys_look_from_the_six_sides) {
  open({"--at", "6"});
  pause();
  const int from = frame();
  const auto first = patch();
  player().key("3");
  // The plate is nearly flat, and is seen from its edge.
  EXPECT_TRUE(wait_until([&] { return times(first) < 0.5; })) << times(first);
  keep("from the left");
  player().key("1");
  EXPECT_TRUE(wait_until([&] { return times(first) > 0.8; })) << times(first);
  player().key("5");
  EXPECT_TRUE(wait_until([&] { return times(first) < 0.5; })) << times(first);
  keep("from the top");
  player().key("2");
  EXPECT_TRUE(wait_until([&] { return times(first) < 0.1 || times(first) > 0.8; }));
  const auto report = quit();
  EXPECT_NEAR(std::abs(report["window"]["camera"]["yaw"].get<double>()), M_PI, 1e-3);
  EXPECT_EQ(report["window"]["frame"], from);
}

TEST_F(LookingWindow, the_u_key_turns_the_scene_upside_down_and_back) {
  open({"--at", "6"});
  pause();
  const int from = frame();
  player().key("u");
  // The front is now on the other side, from which the plate is invisible.
  EXPECT_TRUE(wait_until([&] { return frame() < 0; })) << frame();
  keep("upside down");
  player().key("u");
  EXPECT_TRUE(wait_for_frame(from)) << frame();
  quit();
}

}  // namespace
}  // namespace pointreel::window::looking_test
