// Recordings of a server that is killed and comes back, joined and cut by the real programs.

#include <algorithm>
#include <cmath>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "codec/files/ply.h"
#include "codec/package/manifest.h"
#include "pointreel/package.h"
#include "tests/e2e/process.h"
#include "tests/e2e/server_address.h"
#include "tests/read_file.h"
#include "tests/temporary_folder.h"
#include "tests/tone.h"
#include "tests/wait.h"

namespace pointreel::e2e::edit_test {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

PointCloud spiral(int frame) {
  PointCloud cloud;
  for (int i = 0; i < 2000 + frame; ++i) {
    const float turn = 0.01f * static_cast<float>(i) + static_cast<float>(frame);
    cloud.positions.emplace_back(std::cos(turn), 0.001f * static_cast<float>(i), std::sin(turn));
    cloud.colors.emplace_back(257 * (i % 256), 257 * frame, 0);
  }
  return cloud;
}

std::vector<std::string> segments_of(const fs::path& package) {
  std::vector<std::string> segments;
  const auto manifest = read_manifest(package);
  if (!manifest) return segments;
  for (const Segment& segment : manifest->segments)
    for (const LayerFile& file : segment.layers) segments.push_back(read_file(package / file.path));
  return segments;
}

std::uint32_t frames_of(const fs::path& package) {
  const auto manifest = read_manifest(package);
  return manifest ? manifest->frame_count() : 0;
}

class EditRecordings : public testing::Test {
 protected:
  std::unique_ptr<Background> serve(const std::string& listen) {
    return std::make_unique<Background>(
        "pointreel-server", std::vector<std::string>{"serve", "--live", "--record", path("record"),
                                                     "--listen", listen});
  }
  std::string path(const std::string& name) const { return (folder_ / name).string(); }

  Outcome command(const std::vector<std::string>& arguments) const {
    return run("pointreel-server", arguments);
  }
  void expect_good(const std::string& package) const {
    const Outcome verified = command({"verify", path(package)});
    EXPECT_EQ(verified.exit_code, 0) << verified.out << verified.err;
  }
  /// The decoded frames, in order.
  std::vector<std::string> unpacked(const std::string& package) const {
    const Outcome done = command({"unpack", "-i", path(package), "-o", path(package + ".frames")});
    EXPECT_EQ(done.exit_code, 0) << done.err;
    std::map<std::string, std::string> files;
    for (const auto& entry : fs::directory_iterator(path(package + ".frames")))
      if (entry.path().extension() == ".ply") files[entry.path().filename()] = read_file(entry);
    std::vector<std::string> frames;
    for (auto& [name, content] : files) frames.push_back(std::move(content));
    return frames;
  }

  const TemporaryFolder folder_;
};

TEST_F(EditRecordings, pieces_that_a_crash_has_left_are_joined_and_cut_with_their_sound) {
  if (std::system("ffmpeg -version > /dev/null 2>&1") != 0)
    GTEST_SKIP() << "ffmpeg is not installed";
  fs::create_directories(folder_ / "frames");
  for (int i = 0; i < 3; ++i)
    ASSERT_TRUE(write_ply(folder_ / fmt::format("frames/{}.ply", i), spiral(i)));
  write_wav(folder_ / "tone.wav", 48'000, 96'000,
            [](std::uint32_t n) { return 0.5 * std::sin(0.05 * n); });
  auto server = serve("127.0.0.1:0");
  const std::string address = server_address(*server);
  ASSERT_FALSE(address.empty());
  Background publisher(
      "pointreel-server",
      {"publish", "-i", path("frames"), "--loop", "--fps", "20", "--depth", "8", "--frame-time",
       "100000", "--audio", path("tone.wav"), "--to", "ws://" + address + "/live/stage"});
  ASSERT_TRUE(wait_until([&] { return frames_of(path("record/stage")) >= 30; }));
  server->end(SIGKILL);
  server = serve(address);
  ASSERT_FALSE(server_address(*server).empty());
  ASSERT_TRUE(wait_until([&] { return frames_of(path("record/stage-2")) >= 30; }));
  EXPECT_EQ(publisher.end(SIGINT), 0);
  EXPECT_EQ(server->end(SIGTERM), 0);

  const Outcome joined =
      command({"join", path("record/stage"), path("record/stage-2"), "-o", path("joined")});
  ASSERT_EQ(joined.exit_code, 0) << joined.err;
  EXPECT_EQ(joined.err, "");
  EXPECT_THAT(joined.out, HasSubstr(" s of sound\n"));
  expect_good("joined");
  std::vector<std::string> segments = segments_of(path("record/stage"));
  for (std::string& more : segments_of(path("record/stage-2"))) segments.push_back(std::move(more));
  EXPECT_EQ(segments_of(path("joined")), segments);
  std::vector<std::string> frames = unpacked("record/stage");
  for (std::string& more : unpacked("record/stage-2")) frames.push_back(std::move(more));
  EXPECT_EQ(unpacked("joined"), frames);
  const Manifest first = read_manifest(path("record/stage")).value();
  const Manifest second = read_manifest(path("record/stage-2")).value();
  const Manifest whole = read_manifest(path("joined")).value();
  ASSERT_TRUE(first.audio && second.audio && whole.audio);
  EXPECT_EQ(whole.duration_us, first.duration_us + second.duration_us);
  // The second recording may have more sound than pictures.
  const auto samples = [](std::uint64_t us) { return static_cast<double>(us) * 0.048; };
  EXPECT_NEAR(static_cast<double>(whole.audio->samples),
              std::min(samples(first.duration_us) + static_cast<double>(second.audio->samples),
                       samples(whole.duration_us)),
              1'500.0);

  // From within the second segment to within the last.
  const std::string last = std::to_string(whole.frame_count() - 2);
  const std::string from = std::to_string(first.segments.at(1).first_frame + 1);
  const Outcome cut =
      command({"cut", path("joined"), "-o", path("cut"), "--frames", from + "-" + last});
  ASSERT_EQ(cut.exit_code, 0) << cut.err;
  EXPECT_THAT(cut.out, HasSubstr(fmt::format("cut: frames {} to {} of ", from, last)));
  expect_good("cut");
  EXPECT_EQ(unpacked("cut"),
            std::vector(frames.begin() + first.segments[1].first_frame + 1, frames.end() - 1));

  // By times, and what is not possible.
  EXPECT_EQ(command({"cut", path("joined"), "-o", path("by-time"), "--until", "0.5"}).exit_code, 0);
  EXPECT_EQ(read_manifest(path("by-time"))->duration_us, 500'000u);
  expect_good("by-time");
  const Outcome old =
      command({"cut", path("joined"), "-o", path("by-time"), "--force", "--to", "0.4"});
  EXPECT_EQ(old.exit_code, 0);
  EXPECT_THAT(old.err, HasSubstr("--until"));
  EXPECT_EQ(read_manifest(path("by-time"))->duration_us, 400'000u);
  for (const std::vector<std::string>& wrong : std::vector<std::vector<std::string>>{
           {"cut", path("joined"), "-o", path("no")},
           {"cut", path("joined"), "-o", path("no"), "--from", "2", "--until", "1"},
           {"cut", path("joined"), "-o", path("no"), "--from", "2", "--frames", "3"},
           {"cut", path("joined"), "-o", path("no"), "--frames", "5-3"},
           {"cut", path("joined"), "-o", path("no"), "--frames", "100000"},
           {"cut", path("frames"), "-o", path("no"), "--from", "1"},
           {"cut", path("joined"), "-o", path("by-time"), "--from", "1"},
           {"join", path("joined"), path("frames"), "-o", path("no")},
           {"join", "-o", path("no")}}) {
    const Outcome refused = command(wrong);
    EXPECT_NE(refused.exit_code, 0) << wrong.back();
    EXPECT_FALSE(fs::exists(path("no"))) << wrong.back();
  }

  // From a server that asks for a token.
  Background guarded("pointreel-server", {"serve", path("by-time"), "--view-token", "secret",
                                          "--listen", "127.0.0.1:0"});
  const std::string reel = "http://" + server_address(guarded) + "/by-time";
  for (std::vector<std::string> asked : std::vector<std::vector<std::string>>{
           {"info", reel},
           {"verify", reel},
           {"unpack", reel, path("frames-of-server")},
           {"cut", reel, path("cut-of-server"), "--until", "0.2"},
           {"join", reel, reel, "-o", path("joined-of-server")}}) {
    const Outcome refused = command(asked);
    EXPECT_NE(refused.exit_code, 0) << asked.front();
    EXPECT_THAT(refused.err, HasSubstr("give it with --token"));
    asked.insert(asked.end(), {"--token", "secret"});
    const Outcome done = command(asked);
    EXPECT_EQ(done.exit_code, 0) << done.err;
  }
}

}  // namespace
}  // namespace pointreel::e2e::edit_test
