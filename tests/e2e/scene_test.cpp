#include <filesystem>
#include <fstream>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "codec/files/ply.h"
#include "codec/package/manifest.h"
#include "tests/e2e/picture.h"
#include "tests/e2e/play.h"
#include "tests/e2e/process.h"
#include "tests/e2e/server_address.h"
#include "tests/read_file.h"
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

TEST_F(SceneOfSources, a_reel_that_ends_before_shows_its_last_frame_and_says_so) {
  const Outcome packed =
      run("pointreel-server", {"pack", "-i", path("blue"), "--fps", "10", "-o", path("slow.reel")});
  ASSERT_EQ(packed.exit_code, 0) << packed.err;
  const Outcome played =
      run("pointreel", {"play", path("red.reel"), path("slow.reel"), "--at-position", "-0.5,0,0",
                        "--at-position", "0.5,0,0", "--mode", "point", "--offscreen", "320x200",
                        "--at", "0.25", "--screenshot", path("picture.png")});
  ASSERT_EQ(played.exit_code, 0) << played.err;
  EXPECT_THAT(played.err, testing::HasSubstr("warning: " + path("red.reel") +
                                             ": ends at 0.1 s, "
                                             "before 0.25 s"));
  expect_both();
}

TEST_F(SceneOfSources, each_server_gets_its_own_token) {
  const auto serve = [&](const std::string& reel, const std::string& token) {
    return std::make_unique<Background>(
        "pointreel-server", std::vector<std::string>{"serve", path(reel), "--view-token", token,
                                                     "--listen", "127.0.0.1:0"});
  };
  const auto red = serve("red.reel", "one"), blue = serve("blue.reel", "two");
  const std::string of_red = server_address(*red), of_blue = server_address(*blue);
  folder_.write("tokens", "http://" + of_red + " one\nws://" + of_blue + " two\n");
  std::vector<std::string> play{"play",
                                "http://" + of_red + "/red.reel",
                                "http://" + of_blue + "/blue.reel",
                                "--at-position",
                                "-0.5,0,0",
                                "--at-position",
                                "0.5,0,0",
                                "--mode",
                                "point",
                                "--offscreen",
                                "320x200",
                                "--at",
                                "0",
                                "--screenshot",
                                path("picture.png"),
                                "--token",
                                "one"};
  EXPECT_THAT(run("pointreel", play).err, testing::HasSubstr("it requires a valid token"));
  play.insert(play.end(), {"--token-file", path("tokens")});
  const Outcome played = run("pointreel", play);
  EXPECT_EQ(played.exit_code, 0) << played.err;
  expect_both();
}

TEST_F(SceneOfSources, recordings_of_one_time_are_told_apart) {
  const auto set_captured = [&](const std::string& reel, std::uint64_t captured_us) {
    Manifest manifest = read_manifest(path(reel)).value();
    manifest.captured_us = captured_us;
    std::ofstream(folder_ / reel / "reel.json") << write_manifest(manifest);
  };
  const std::vector<std::string> play{"play",  path("red.reel"), path("blue.reel"),   "--offscreen",
                                      "64x64", "--screenshot",   path("picture.png"), "--at",
                                      "0"};
  constexpr std::uint64_t kThen = 1'700'000'000'000'000;
  set_captured("blue.reel", kThen);
  for (const auto& [captured_us, said] :
       {std::pair{kThen + 60'000, true}, {kThen + 20'000, false}, {kThen + 5'000'000, false}}) {
    set_captured("red.reel", captured_us);
    const Outcome played = run("pointreel", play);
    EXPECT_EQ(played.exit_code, 0) << played.err;
    const std::string blue = path("blue.reel");
    EXPECT_EQ(played.err.find("warning: " + path("red.reel") + ": was captured 0.060 s after " +
                              blue) != std::string::npos,
              said)
        << played.err;
    EXPECT_EQ(played.err.find("cut " + blue + " NEW --from 0.060") != std::string::npos, said);
  }
}

TEST_F(SceneOfSources, a_source_that_cannot_be_shown_is_an_error) {
  for (const auto& file : std::filesystem::directory_iterator(path("blue.reel")))
    if (file.path().extension() == ".prs") std::filesystem::resize_file(file.path(), 1);
  const std::vector<std::string> play{"play",  path("red.reel"), path("blue.reel"),  "--offscreen",
                                      "64x64", "--screenshot",   path("picture.png")};
  Outcome played = run("pointreel", play);
  EXPECT_EQ(played.exit_code, 1);
  EXPECT_THAT(played.err, testing::HasSubstr(path("blue.reel") + ": no frame could be shown"));
  EXPECT_THAT(played.err, testing::Not(testing::HasSubstr("red.reel:")));
  EXPECT_TRUE(std::filesystem::exists(path("picture.png"))) << "of what was there";

  std::filesystem::remove(path("picture.png"));
  std::vector<std::string> one_picture = play;
  one_picture.insert(one_picture.end(), {"--at", "0"});
  played = run("pointreel", one_picture);
  EXPECT_EQ(played.exit_code, 1);
  EXPECT_THAT(played.err, testing::HasSubstr(path("blue.reel") + ": no frame could be shown"));
  EXPECT_FALSE(std::filesystem::exists(path("picture.png")));
}

TEST_F(SceneOfSources, a_live_stream_that_refuses_ends_it_and_has_no_picture_of_a_time) {
  Background server("pointreel-server",
                    {"serve", "--live", "--view-token", "secret", "--listen", "127.0.0.1:0"});
  const std::string address = server_address(server);
  ASSERT_FALSE(address.empty());
  for (const std::string& live :
       {"ws://" + address + "/live/red", "http://" + address + "/live/red"}) {
    const Outcome refused = run("pointreel", {"play", path("blue.reel"), live, "--token", "wrong",
                                              "--loop", "--offscreen", "64x64"});
    EXPECT_EQ(refused.exit_code, 1);
    EXPECT_THAT(refused.err, testing::HasSubstr("it requires a valid token"));
    const Outcome endless =
        run("pointreel", {"play", path("blue.reel"), live, "--at", "0", "--offscreen", "64x64"});
    EXPECT_EQ(endless.exit_code, 2);
    EXPECT_THAT(endless.err, testing::HasSubstr("--at: " + live + " is live"));
  }
}

TEST_F(SceneOfSources, secrets_in_addresses_are_not_printed) {
  std::filesystem::copy(path("blue.reel"), path("bad.reel"));
  for (const auto& file : std::filesystem::directory_iterator(path("bad.reel")))
    if (file.path().extension() == ".prs") {
      std::string bytes = read_file(file.path());
      bytes.back() = static_cast<char>(bytes.back() + 1);
      std::ofstream(file.path(), std::ios::binary) << bytes;
    }
  Background server("pointreel-server",
                    {"serve", folder_.path().string(), "--live", "--listen", "127.0.0.1:0"});
  const std::string address = server_address(server);
  ASSERT_FALSE(address.empty());
  const std::string good = "http://" + address + "/blue.reel/reel.json?Signature=SEKRET",
                    bad = "http://" + address + "/bad.reel/reel.json?Signature=SEKRET",
                    live = "ws://" + address + "/live/none?token=SEKRET";
  const std::vector<std::pair<std::string, std::vector<std::string>>> commands{
      {"pointreel-server", {"verify", good}},
      {"pointreel-server", {"verify", bad}},
      {"pointreel-server", {"publish", path("red"), "--to", live + "&x"}},
      {"pointreel", {"play", good, "--offscreen", "64x64", "--at", "99"}},
      {"pointreel", {"play", good, "--offscreen", "64x64", "--at", "0", "--json", "-"}},
      {"pointreel", {"play", bad, "--offscreen", "64x64"}},
      {"pointreel", {"play", path("red.reel"), bad, "--offscreen", "64x64"}},
      {"pointreel", {"play", live, "--offscreen", "64x64", "--duration", "0.3"}},
      {"pointreel", {"play", "ws://user:SEKRET@" + address + "/live/x", "--offscreen", "64x64"}},
      {"pointreel", {"play", "http://user:SEKRET@host:99999/x", "--offscreen", "64x64"}},
  };
  for (const auto& [program, arguments] : commands) {
    const Outcome outcome = run(program, arguments);
    EXPECT_NE(outcome.out + outcome.err, "") << testing::PrintToString(arguments);
    EXPECT_THAT(outcome.out + outcome.err, testing::Not(testing::HasSubstr("SEKRET")))
        << testing::PrintToString(arguments);
  }
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
