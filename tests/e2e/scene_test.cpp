#include <filesystem>
#include <string>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "codec/files/ply.h"
#include "tests/e2e/picture.h"
#include "tests/e2e/play.h"
#include "tests/e2e/process.h"
#include "tests/e2e/server_address.h"
#include "tests/temporary_folder.h"

namespace pointreel::e2e::scene_test {
namespace {

/// A square plate of a single colour that faces the front.
PointCloud plate(const glm::u8vec3& color) {
  PointCloud cloud;
  for (int i = 0; i < 60 * 60; ++i) {
    cloud.positions.push_back(0.01f * glm::vec3(i % 60 - 30, i / 60 - 30, 0));
    cloud.normals.emplace_back(0.0f, 0.0f, 1.0f);
    cloud.colors.push_back(glm::u16vec3(color) * std::uint16_t{257});
  }
  return cloud;
}

class SceneOfSources : public testing::Test {
 protected:
  void SetUp() override {
    for (const auto& [name, color] :
         {std::pair{"red", glm::u8vec3(230, 10, 10)}, {"blue", glm::u8vec3(10, 10, 230)}}) {
      const auto clouds = folder_ / name;
      std::filesystem::create_directories(clouds);
      for (int frame = 0; frame < 3; ++frame) {
        ASSERT_TRUE(write_ply(clouds / fmt::format("{}.ply", frame), plate(color)));
      }
      const Outcome packed = run("pointreel-server", {"pack", "-i", clouds.string(), "-o",
                                                      (folder_ / name).string() + ".reel"});
      ASSERT_EQ(packed.exit_code, 0) << packed.err;
    }
  }
  std::string path(const std::string& name) const { return (folder_ / name).string(); }

  /// Plays until more than two frames of each reel were shown.
  nlohmann::json play(const std::string& red, const std::string& blue) {
    const auto report = play_until(
        {red, blue, "--at-position", "-0.5,0,0", "--at-position", "0.5,0,0", "--mode", "point",
         "--offscreen", "320x200", "--loop", "--screenshot", path("picture.png")},
        [](const nlohmann::json& told) {
          return told["sources"][0]["frames_shown"] > 2 && told["sources"][1]["frames_shown"] > 2;
        });
    EXPECT_FALSE(report.is_discarded());
    expect_both();
    return report;
  }

  /// Red must be on the left and blue on the right.
  void expect_both() const {
    const Picture picture = read_picture(folder_ / "picture.png");
    const Patch left = find_hue(picture, {1, 0, 0}), right = find_hue(picture, {0, 0, 1});
    EXPECT_GT(left.pixels, 500u);
    EXPECT_GT(right.pixels, 500u);
    EXPECT_LT(left.center.x, 150.0);
    EXPECT_GT(right.center.x, 170.0);
    EXPECT_NEAR(left.center.y, right.center.y, 5.0);
  }

  TemporaryFolder folder_;
};

TEST_F(SceneOfSources, two_reels_are_drawn_at_their_positions) {
  const auto report = play(path("red.reel"), path("blue.reel"));
  ASSERT_FALSE(report.is_discarded());
  ASSERT_EQ(report["sources"].size(), 2u);
  EXPECT_GT(report["sources"][0]["frames_shown"], 2);
  EXPECT_GT(report["sources"][1]["frames_shown"], 2);
}

TEST_F(SceneOfSources, one_picture_shows_both_reels_at_one_time) {
  const Outcome played =
      run("pointreel", {"play", path("red.reel"), path("blue.reel"), "--at-position", "-0.5,0,0",
                        "--at-position", "0.5,0,0", "--mode", "point", "--offscreen", "320x200",
                        "--at", "0.04", "--screenshot", path("picture.png"), "--json", "-"});
  ASSERT_EQ(played.exit_code, 0) << played.err;
  expect_both();
  const auto report = nlohmann::json::parse(played.out);
  EXPECT_EQ(report["sources"][0]["frames_shown"], 1);
  EXPECT_EQ(report["sources"][1]["frames_shown"], 1);
}

TEST_F(SceneOfSources, a_live_stream_and_a_reel_share_one_scene) {
  Background server("pointreel-server", {"serve", "--live", "--listen", "127.0.0.1:0"});
  const std::string address = server_address(server);
  ASSERT_FALSE(address.empty());
  const std::string url = "ws://" + address + "/live/red";
  Background publisher("pointreel-server",
                       {"publish", "-i", path("red"), "--loop", "--fps", "20", "--to", url});
  const auto report = play(url, path("blue.reel"));
  ASSERT_FALSE(report.is_discarded());
  const auto& live = report["sources"][0]["live"];
  EXPECT_GT(live["frames"], 2);
  EXPECT_EQ(live["bad_messages"], 0);
  EXPECT_GT(live["capture_to_picture_ms"]["median"], 0.0);
  EXPECT_LT(live["capture_to_picture_ms"]["median"], 10'000.0);
}

TEST_F(SceneOfSources, a_point_far_away_in_a_later_frame_does_not_hide_the_first) {
  PointCloud far = plate({230, 10, 10});
  far.positions[0].x = 1000.0f;
  ASSERT_TRUE(write_ply(folder_ / "red/1.ply", far));
  const Outcome packed = run("pointreel-server", {"pack", "-i", path("red"), "-o", path("far")});
  ASSERT_EQ(packed.exit_code, 0) << packed.err;
  Background server("pointreel-server",
                    {"serve", path("far"), "--live", "--listen", "127.0.0.1:0"});
  const std::string address = server_address(server);
  ASSERT_FALSE(address.empty());
  const auto plate_pixels = [&] {
    return find_hue(read_picture(folder_ / "picture.png"), {1, 0, 0}).pixels;
  };
  for (const std::string& source : {path("far"), "http://" + address + "/far"})
    for (const char* mode : {"surfel", "voxel", "point"}) {
      const Outcome played =
          run("pointreel", {"play", source, "--mode", mode, "--offscreen", "320x200", "--at", "0",
                            "--screenshot", path("picture.png")});
      EXPECT_EQ(played.exit_code, 0) << played.err;
      EXPECT_GT(plate_pixels(), 500u) << source << ", " << mode;
    }
  const std::string live = "ws://" + address + "/live/red";
  // Slow enough for a busy machine: a publisher that is late sends coarser frames, in which the
  // plate is a speck beside the point far away.
  Background publisher("pointreel-server",
                       {"publish", "-i", path("red"), "--loop", "--fps", "4", "--to", live});
  // The second time, the bounds in the hello are as large from the beginning.
  for (int i = 0; i < 2; ++i) {
    const auto report =
        play_until({live, "--offscreen", "320x200", "--screenshot", path("picture.png")},
                   [](const nlohmann::json& told) { return told["frames_shown"] > 5; });
    ASSERT_FALSE(report.is_discarded());
    EXPECT_GT(plate_pixels(), 500u) << "live";
  }
}

TEST_F(SceneOfSources, more_positions_than_sources_are_a_usage_error) {
  const Outcome played = run("pointreel", {"play", path("red.reel"), "--at-position", "1,0,0",
                                           "--at-position", "0,0,0", "--offscreen", "32x32"});
  EXPECT_EQ(played.exit_code, 2);
  EXPECT_THAT(played.err, testing::HasSubstr("--at-position"));
  const Outcome wrong = run("pointreel", {"play", path("red.reel"), "--at-position", "1;2;3"});
  EXPECT_EQ(wrong.exit_code, 2);
  EXPECT_THAT(wrong.err, testing::HasSubstr("is not a position"));
}

}  // namespace
}  // namespace pointreel::e2e::scene_test
