// Camera paths, recorded in the window and followed there.

#include "client/scene/camera_path.h"

#include <cmath>
#include <filesystem>

#include <gtest/gtest.h>

#include "tests/window/window_test.h"

namespace pointreel::window::camera_path_test {
namespace {

class CameraPathWindow : public WindowTest {
 protected:
  // The player writes into the current folder.
  void SetUp() override {
    WindowTest::SetUp();
    std::filesystem::current_path(folder_.path());
  }
  void TearDown() override { std::filesystem::current_path(before_); }

  const std::filesystem::path before_ = std::filesystem::current_path();
};

TEST_F(CameraPathWindow, the_k_key_records_a_camera_path_that_the_player_follows) {
  const std::string file = (folder_ / "pointreel-camera-0001.json").string();
  const auto keys = [&] {
    const auto path = load_camera_path(file);
    return path ? path->keys.size() : 0;
  };
  open({"--at", "1"});
  pause();
  const int from = frame();
  const glm::ivec2 middle = player().size() / 2;
  player().drag(middle, middle + glm::ivec2(560, 0));
  EXPECT_TRUE(wait_until([&] { return std::abs(frame() - from) > 3; }));
  player().key("k");
  EXPECT_TRUE(wait_until([&] { return keys() == 1; }));
  player().key("0");
  EXPECT_TRUE(wait_for_frame(from));
  player().key("Right");
  EXPECT_TRUE(wait_for_frame(from + 5 * MovingPlate::kFps));
  player().key("k");
  EXPECT_TRUE(wait_until([&] { return keys() == 2; }));
  quit();

  const auto path = load_camera_path(file);
  ASSERT_TRUE(path) << path.error().message;
  ASSERT_EQ(path->keys.size(), 2u);
  EXPECT_GT(std::abs(path->keys[0].yaw), 0.8);
  EXPECT_EQ(path->keys[1].yaw, 0.0);
  EXPECT_NEAR(static_cast<double>(path->keys[1].time_us - path->keys[0].time_us), 5e6, 2e5);

  // Behind the last key, the view is the first one. Near the first key, it has turned most of the
  // way.
  open({"--camera", file, "--at", "9"});
  pause();
  const int late = frame();
  EXPECT_GE(late, 9 * MovingPlate::kFps);
  player().key("Left");
  for (int i = 0; i < 3; ++i) player().key("shift+Left");
  const int earlier = late - 8 * MovingPlate::kFps;
  EXPECT_TRUE(wait_until([&] {
    return std::abs(frame() - late) > 3 && std::abs(frame() - earlier) > 3;
  })) << frame();
  keep("on_a_camera_path");
  player().key("Right");
  for (int i = 0; i < 3; ++i) player().key("shift+Right");
  EXPECT_TRUE(wait_for_frame(late));
  quit();
}

}  // namespace
}  // namespace pointreel::window::camera_path_test
