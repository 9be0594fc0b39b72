// The settings that the window remembers.

#include <algorithm>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/window/window_test.h"

namespace pointreel::window::settings_test {
namespace {

using testing::HasSubstr;

class SettingsWindow : public WindowTest {
 protected:
  void write_settings(const std::string& text) const {
    folder_.write("config/pointreel/player.json", text);
  }
};

TEST_F(SettingsWindow, settings_are_read_and_overridden_by_the_command_line) {
  write_settings(R"({"window": [700, 500], "mode": "voxel", "splatting": "regular"})");
  open({"--splatting", "two-pass"});
  EXPECT_TRUE(wait_for_next_frame());
  EXPECT_EQ(player().size(), glm::ivec2(700, 500));
  const auto report = quit();
  EXPECT_EQ(report["mode"], "voxel");
  EXPECT_EQ(report["splatting"], "two-pass");
  EXPECT_EQ(player().err(), "");
}

TEST_F(SettingsWindow, changes_are_restored_the_next_time) {
  open();
  EXPECT_TRUE(wait_for_next_frame());
  player().key("m");
  player().key("L");
  player().key("i");
  player().resize({900, 640});
  EXPECT_TRUE(wait_until([&] { return player().size() == glm::ivec2(900, 640); }));
  EXPECT_TRUE(wait_for_next_frame());
  quit();
  open();
  EXPECT_TRUE(wait_for_next_frame());
  EXPECT_EQ(player().size(), glm::ivec2(900, 640));
  const auto report = quit();
  EXPECT_EQ(report["mode"], "voxel");
  EXPECT_FALSE(report["window"]["loop"].get<bool>());
  EXPECT_TRUE(report["window"]["shown"]["statistics"].get<bool>());
}

TEST_F(SettingsWindow, the_size_in_full_screen_is_not_remembered) {
  open();
  EXPECT_TRUE(wait_for_next_frame());
  player().key("f");
  EXPECT_TRUE(wait_until([&] { return player().size() == glm::ivec2(1600, 1000); }));
  quit();
  open();
  EXPECT_EQ(player().size(), glm::ivec2(1280, 720));
  quit();
}

TEST_F(SettingsWindow, a_broken_file_is_reported_in_one_line_and_playback_starts_anyway) {
  write_settings("{\"mode\": \"disc\"}");
  open();
  EXPECT_TRUE(wait_for_next_frame());
  EXPECT_EQ(quit()["mode"], "surfel");
  const std::string err = player().err();
  EXPECT_THAT(err, HasSubstr("player.json: \"mode\": \"disc\" is not one of surfel, voxel, point"));
  EXPECT_EQ(std::count(err.begin(), err.end(), '\n'), 1) << err;
}

TEST_F(SettingsWindow, another_file_or_none_can_be_chosen) {
  write_settings(R"({"mode": "voxel"})");
  const std::string other = folder_.write("other.json", R"({"mode": "point"})");
  open({"--config", other});
  EXPECT_TRUE(wait_for_next_frame());
  EXPECT_EQ(quit()["mode"], "point");
  open({"--no-config"});
  EXPECT_TRUE(wait_for_next_frame());
  EXPECT_EQ(quit()["mode"], "surfel");
}

}  // namespace
}  // namespace pointreel::window::settings_test
