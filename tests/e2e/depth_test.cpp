// Depth cameras' pictures and videos from files to pictures, as a user sees them.

#include <cstdlib>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/depth_scene.h"
#include "tests/e2e/picture.h"
#include "tests/e2e/process.h"
#include "tests/read_file.h"
#include "tests/temporary_folder.h"

namespace pointreel::e2e::depth_test {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;

constexpr int kFrames = 6;

class Depth : public testing::Test {
 protected:
  void SetUp() override { depth_scene::write(capture(), kFrames, depth_scene::camera(320)); }

  std::string capture() const { return (folder_ / "capture").string(); }
  std::string reel() const { return (folder_ / "reel").string(); }
  std::string video() const { return (folder_ / "walk.mkv").string(); }

  void make_video() const {
    const auto made = depth_scene::write_video(capture(), video(), 10);
    ASSERT_TRUE(made) << made.error().message;
  }

  /// The red ball in a picture of the source, from where the camera was.
  Patch ball(const std::string& source, const std::string& time) const {
    const std::string file = (folder_ / "picture.png").string();
    const Outcome drawn =
        run("pointreel", {"play", source, "--offscreen", "320x240", "--at", time, "--view", "0,0",
                          "--no-lighting", "--screenshot", file});
    EXPECT_EQ(drawn.exit_code, 0) << drawn.err;
    const Picture picture = read_picture(file);
    EXPECT_EQ(picture.size, glm::ivec2(320, 240));
    return find_hue(picture, {1, 0, 0});
  }

  const TemporaryFolder folder_;
};

TEST_F(Depth, a_folder_of_pictures_is_packed_and_played_upright) {
  const Outcome packed =
      run("pointreel-server", {"pack", "-i", capture(), "-o", reel(), "--fps", "10", "--json"});
  ASSERT_EQ(packed.exit_code, 0) << packed.err;
  const auto summary = nlohmann::json::parse(packed.out, nullptr, false);
  ASSERT_FALSE(summary.is_discarded()) << packed.out;
  EXPECT_EQ(summary["frames"], kFrames);
  EXPECT_GT(summary["points"], kFrames * 320 * 240 * 9 / 10);
  EXPECT_EQ(summary["warnings"].size(), 0u) << packed.out;
  EXPECT_THAT(run("pointreel-server", {"verify", reel()}).out, HasSubstr(": OK, "));
  EXPECT_THAT(run("pointreel-server", {"info", reel()}).out,
              AllOf(HasSubstr("colors yes, normals yes"), HasSubstr("up y")));
  // The pictures of a folder without times are played at 30 a second.
  for (const auto& [source, end] : {std::pair{capture(), "0.16"}, std::pair{reel(), "0.5"}}) {
    const Patch first = ball(source, "0"), last = ball(source, end);
    EXPECT_GT(first.pixels, 1000u) << source;
    EXPECT_GT(last.center.x, first.center.x + 10.0) << source;
  }
}

TEST_F(Depth, a_video_is_packed_and_played_at_its_times) {
  make_video();
  const Outcome packed = run("pointreel-server", {"pack", "-i", video(), "-o", reel(), "--json"});
  ASSERT_EQ(packed.exit_code, 0) << packed.err;
  const auto summary = nlohmann::json::parse(packed.out, nullptr, false);
  ASSERT_FALSE(summary.is_discarded()) << packed.out;
  EXPECT_EQ(summary["frames"], kFrames);
  EXPECT_EQ(summary["recorded_fps"], 10.0);
  for (const std::string& source : {video(), reel()}) {
    const Patch first = ball(source, "0"), last = ball(source, "0.5");
    EXPECT_GT(first.pixels, 1000u) << source;
    EXPECT_GT(last.center.x, first.center.x + 10.0) << source;
  }
}

TEST_F(Depth, a_video_is_packed_in_parts_with_its_times) {
  make_video();
  const auto pack = [&](std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), "pack");
    const Outcome done = run("pointreel-server", arguments);
    EXPECT_EQ(done.exit_code, 0) << done.err;
  };
  const std::string whole = reel() + "-whole";
  pack({"-i", video(), "-o", whole, "--name", "walk", "--segment", "2"});
  pack({"plan", "-i", video(), "-o", reel(), "--name", "walk", "--segment", "2"});
  pack({"part", "2/2", "-o", reel()});
  pack({"part", "1/2", "-o", reel()});
  pack({"join", "-o", reel()});
  EXPECT_EQ(read_file(fs::path(reel()) / "reel.json"), read_file(fs::path(whole) / "reel.json"));
}

TEST_F(Depth, missing_tools_are_named_in_one_line) {
  make_video();
  const std::string path = std::getenv("PATH");
  ::setenv("PATH", "/nonexistent", 1);
  const Outcome packed = run("pointreel-server", {"pack", "-i", video(), "-o", reel()});
  ::setenv("PATH", path.c_str(), 1);
  EXPECT_EQ(packed.exit_code, 1);
  EXPECT_THAT(packed.err, HasSubstr("walk.mkv: ffmpeg is not installed, but videos need it"));
  EXPECT_FALSE(fs::exists(reel()));
}

}  // namespace
}  // namespace pointreel::e2e::depth_test
