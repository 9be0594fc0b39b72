// How it is drawn, from where, and how large.

#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/window/window_test.h"

namespace pointreel::window {
namespace {

class LookingWindow : public WindowTest {
 protected:
  /// How many pixels the plate has, of so many.
  double times(const e2e::Patch& first) {
    return static_cast<double>(patch().pixels) / static_cast<double>(first.pixels);
  }
  e2e::Patch patch() { return MovingPlate::plate(player().picture()); }
};

TEST_F(LookingWindow, m_draws_surfels_then_voxels_then_points) {
  for (const auto& [times, mode] : {std::pair{1, "voxel"}, {2, "point"}, {3, "surfel"}}) {
    open({"--mode", "surfel"});  // it remembers the last one
    pause();
    const e2e::Picture before = player().picture();
    for (int i = 0; i < times; ++i) player().key("m");
    if (times < 3) {
      EXPECT_TRUE(wait_until([&] { return player().picture().pixels != before.pixels; }));
    }
    keep(mode);
    EXPECT_EQ(quit()["mode"], mode);
  }
}

TEST_F(LookingWindow, the_left_button_turns_the_right_one_moves_the_wheel_zooms_and_0_resets) {
  open({"--at", "6"});
  pause();
  const int from = frame();
  const glm::ivec2 middle = player().size() / 2;
  const auto first = patch();

  player().drag(middle, middle + glm::ivec2(150, 0));
  EXPECT_TRUE(wait_until([&] { return times(first) < 0.95; })) << "turned";
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
  EXPECT_TRUE(wait_until([&] { return times(first) > 1.4; })) << "nearer";
  player().scroll(-3);
  EXPECT_TRUE(wait_until([&] { return times(first) < 1.1; })) << "farther";
  quit();
}

TEST_F(LookingWindow, a_window_of_another_size_shows_the_same_frame) {
  open({"--at", "4"});
  pause();
  const int from = frame();
  for (const glm::ivec2 size : {glm::ivec2(800, 600), glm::ivec2(1500, 500)}) {
    player().resize(size);
    EXPECT_TRUE(wait_until([&] { return player().size() == size && frame() == from; }))
        << size.x << ": " << frame();
  }
  keep("resized");
  EXPECT_EQ(quit()["size"], nlohmann::json({1500, 500}));
}

TEST_F(LookingWindow, f_fills_the_screen_and_gives_the_window_back) {
  open({"--at", "4"});
  pause();
  const glm::ivec2 before = player().size();
  player().key("f");
  EXPECT_TRUE(wait_until([&] { return player().size() == glm::ivec2(1600, 1000); }));
  EXPECT_TRUE(wait_until([&] { return frame() >= 0; }));
  player().key("f");
  EXPECT_TRUE(wait_until([&] { return player().size() == before; }));
  quit();
}

}  // namespace
}  // namespace pointreel::window
