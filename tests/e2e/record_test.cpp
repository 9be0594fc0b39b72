// Recordings, made as a user makes them.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "codec/files/ply.h"
#include "tests/e2e/picture.h"
#include "tests/e2e/process.h"
#include "tests/read_file.h"
#include "tests/temporary_folder.h"
#include "tests/tone.h"

namespace pointreel::e2e::record_test {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

constexpr int kFrames = 6;

/// A red cube that moves from left to right between green ones, which stand still.
PointCloud scene(int frame) {
  PointCloud cloud;
  const auto add_cube = [&](const glm::vec3& center, const glm::u8vec3& color) {
    for (int x = -10; x <= 10; ++x)
      for (int y = -10; y <= 10; ++y)
        for (const int z : {-10, 10}) {
          cloud.positions.push_back(center + 0.01f * glm::vec3(x, y, z));
          cloud.colors.push_back(glm::u16vec3(color) * std::uint16_t{257});
        }
  };
  add_cube({-1.0f, -0.5f, 0.0f}, {20, 220, 20});
  add_cube({1.0f, -0.5f, 0.0f}, {20, 220, 20});
  add_cube({-1.0f + 0.4f * static_cast<float>(frame), 0.5f, 0.0f}, {220, 20, 20});
  return cloud;
}

class Record : public testing::Test {
 protected:
  void SetUp() override {
    // Nothing here may need a display.
    unsetenv("DISPLAY");
    unsetenv("WAYLAND_DISPLAY");
    fs::create_directories(folder_ / "in");
    for (int i = 0; i < kFrames; ++i)
      ASSERT_TRUE(write_ply(folder_ / fmt::format("in/frame{}.ply", i), scene(i)));
  }

  Outcome play(std::vector<std::string> arguments) const {
    std::vector<std::string> all = {
        "play",   (folder_ / "in").string(), "--fps", "10", "--mode", "point", "--offscreen",
        "160x120"};
    all.insert(all.end(), arguments.begin(), arguments.end());
    return run("pointreel", all);
  }

  std::string path(const std::string& name) const { return (folder_ / name).string(); }

  /// The pictures of a video, each as often as the video contains it.
  std::vector<Picture> pictures_of(const std::string& video) const {
    fs::create_directories(folder_ / "frames");
    const std::string command = "ffmpeg -v error -i '" + path(video) +
                                "' -fps_mode passthrough -start_number 0 '" + path("frames") +
                                "/%03d.png'";
    EXPECT_EQ(std::system(command.c_str()), 0);
    std::vector<Picture> pictures;
    for (int i = 0; fs::exists(folder_ / fmt::format("frames/{:03}.png", i)); ++i)
      pictures.push_back(read_picture(folder_ / fmt::format("frames/{:03}.png", i)));
    return pictures;
  }

  const TemporaryFolder folder_;
};

bool has_ffmpeg() { return std::system("ffmpeg -version > /dev/null 2>&1") == 0; }

double red_x(const Picture& picture) { return find_hue(picture, {1, 0, 0}).center.x; }

TEST_F(Record, a_video_has_every_frame_once_in_order) {
  if (!has_ffmpeg()) GTEST_SKIP() << "ffmpeg is not installed";
  const Outcome played = play({"--camera", "front", "--record", path("out.mp4"), "--json", "-"});
  ASSERT_EQ(played.exit_code, 0) << played.err;
  EXPECT_EQ(played.err, "");  // no progress bar without a terminal
  const auto report = nlohmann::json::parse(played.out, nullptr, false);
  EXPECT_EQ(report["frames_shown"], kFrames);
  const std::vector<Picture> pictures = pictures_of("out.mp4");
  ASSERT_EQ(pictures.size(), static_cast<std::size_t>(kFrames));
  for (std::size_t i = 1; i < pictures.size(); ++i)
    EXPECT_GT(red_x(pictures[i]), red_x(pictures[i - 1]) + 8) << i;
}

TEST_F(Record, a_looped_recording_lasts_for_the_given_duration) {
  if (!has_ffmpeg()) GTEST_SKIP() << "ffmpeg is not installed";
  const Outcome played = play({"--camera", "front", "--record", path("out.webm"), "--screenshot",
                               path("last.png"), "--loop", "--duration", "1", "--json", "-"});
  ASSERT_EQ(played.exit_code, 0) << played.err;
  EXPECT_EQ(nlohmann::json::parse(played.out, nullptr, false)["frames_shown"], 10);
  const std::vector<Picture> pictures = pictures_of("out.webm");
  ASSERT_EQ(pictures.size(), 10u);
  EXPECT_NEAR(red_x(pictures_of("last.png").at(0)), red_x(pictures.back()), 1.5);
  for (std::size_t i = kFrames; i < pictures.size(); ++i)
    EXPECT_NEAR(red_x(pictures[i]), red_x(pictures[i - kFrames]), 1.5) << i;
}

TEST_F(Record, a_video_has_the_sound_of_its_part_of_the_reel) {
  if (!has_ffmpeg()) GTEST_SKIP() << "ffmpeg is not installed";
  write_wav(folder_ / "a.wav", 48'000, 48'000,
            [](std::uint32_t n) { return n < 24'000 ? 0.0 : 0.5 * std::sin(0.1 * n); });
  ASSERT_EQ(run("pointreel-server", {"pack", "-i", path("in"), "-o", path("reel"), "--fps", "6",
                                     "--audio", path("a.wav")})
                .exit_code,
            0);
  const Outcome played =
      run("pointreel", {"play", path("reel"), "--mode", "point", "--offscreen", "160x120", "--at",
                        "0.34", "--duration", "1", "--record", path("out.mkv")});
  ASSERT_EQ(played.exit_code, 0) << played.err;
  // It begins with the frame at a third of a second, and the tone begins half a second into it.
  const std::string command = "ffmpeg -v error -i '" + path("out.mkv") +
                              "' -f f32le -af 'pan=mono|c0=c0' -ar 48000 '" + path("out.f32") + "'";
  ASSERT_EQ(std::system(command.c_str()), 0);
  const std::string raw = read_file(folder_ / "out.f32");
  std::vector<float> samples(raw.size() / sizeof(float));
  std::memcpy(samples.data(), raw.data(), samples.size() * sizeof(float));
  EXPECT_NEAR(static_cast<double>(samples.size()), 32'000.0, 1.0);
  const auto begin = std::find_if(samples.begin(), samples.end(),
                                  [](float sample) { return std::abs(sample) > 0.1f; });
  EXPECT_NEAR(static_cast<double>(begin - samples.begin()), 8'000.0, 100.0);

  ASSERT_EQ(run("pointreel", {"play", path("reel"), "--mode", "point", "--offscreen", "160x120",
                              "--no-audio", "--record", path("silent.mkv")})
                .exit_code,
            0);
  const std::string probe =
      "ffprobe -v error -select_streams a -show_entries stream=index -of "
      "csv=p=0 '" +
      path("silent.mkv") + "' > '" + path("probe") + "'";
  ASSERT_EQ(std::system(probe.c_str()), 0);
  EXPECT_EQ(read_file(folder_ / "probe"), "");
}

TEST_F(Record, the_camera_follows_its_path_frame_by_frame) {
  folder_.write("path.json", R"({"pointreel_camera_path": 1, "keys": [
    {"seconds": 0, "yaw": 0}, {"seconds": 0.2, "yaw": 0}, {"seconds": 0.4, "yaw": 180}]})");
  const Outcome played = play({"--camera", path("path.json"), "--record", path("out-%d.png"),
                               "--screenshot", path("last.png")});
  ASSERT_EQ(played.exit_code, 0) << played.err;
  EXPECT_FALSE(fs::exists(folder_ / fmt::format("out-{}.png", kFrames)));
  // Seen from the front it moves to the right, from the back to the left.
  const auto x = [&](int i) { return red_x(read_picture(folder_ / fmt::format("out-{}.png", i))); };
  EXPECT_GT(x(1), x(0) + 8);
  EXPECT_GT(x(2), x(1) + 8);
  EXPECT_LT(x(5), x(4) - 8);
  EXPECT_EQ(read_file(folder_ / "last.png"), read_file(folder_ / "out-5.png"));
  // A screenshot of a single frame is the same picture.
  ASSERT_EQ(play({"--camera", path("path.json"), "--at", "0.3", "--screenshot", path("one.png")})
                .exit_code,
            0);
  EXPECT_EQ(read_file(folder_ / "one.png"), read_file(folder_ / "out-3.png"));
}

TEST_F(Record, a_missing_ffmpeg_is_reported_in_one_line_before_anything_is_drawn) {
  setenv("PATH", path("none").c_str(), 1);
  const Outcome played = play({"--record", path("out.mp4"), "--screenshot", path("last.png")});
  EXPECT_EQ(played.exit_code, 1);
  EXPECT_THAT(played.err, HasSubstr("pointreel: ffmpeg is not installed"));
  EXPECT_EQ(std::count(played.err.begin(), played.err.end(), '\n'), 1);
  EXPECT_FALSE(fs::exists(folder_ / "last.png"));
}

TEST_F(Record, a_folder_that_does_not_exist_is_reported_before_anything_is_drawn) {
  for (const std::string option : {"--record", "--screenshot", "--json"}) {
    const std::string file = path("none/out.png");
    const Outcome played =
        play({option, option == "--record" ? path("none/%d.png") : file, "--camera", "front"});
    EXPECT_EQ(played.exit_code, 2) << option;
    EXPECT_THAT(played.err, HasSubstr("there is no folder " + path("none"))) << option;
    EXPECT_EQ(played.out, "") << option;
  }
}

TEST_F(Record, what_shows_no_frame_is_an_error) {
  ASSERT_EQ(run("pointreel-server", {"pack", "-i", path("in"), "-o", path("reel")}).exit_code, 0);
  for (const auto& entry : fs::directory_iterator(folder_ / "reel")) {
    if (entry.path().extension() == ".prs")
      folder_.write("reel/" + entry.path().filename().string(), std::string(entry.file_size(), 0));
  }
  const std::string reel = path("reel");
  // Several reels are played by the clock, a single one picture by picture.
  for (const auto& reels : {std::vector{reel}, std::vector{reel, reel}}) {
    std::vector<std::string> arguments{"play", "--offscreen", "160x120", "--record",
                                       path("out-%d.png")};
    arguments.insert(arguments.end(), reels.begin(), reels.end());
    const Outcome played = run("pointreel", arguments);
    EXPECT_EQ(played.exit_code, 1) << played.err;
    EXPECT_THAT(played.err, HasSubstr(": no frame could be shown"));
    EXPECT_FALSE(fs::exists(folder_ / "out-0.png"));
  }
}

TEST_F(Record, an_invalid_camera_path_is_a_usage_error) {
  const Outcome played = play({"--camera", path("in/frame0.ply")});
  EXPECT_EQ(played.exit_code, 2);
  EXPECT_THAT(played.err, HasSubstr("frame0.ply: is not valid JSON"));
}

}  // namespace
}  // namespace pointreel::e2e::record_test
