// Layered depth video by the real programs: packed, verified, unpacked, cut, joined and drawn.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "codec/distance/distance.h"
#include "codec/files/ply.h"
#include "codec/package/manifest.h"
#include "pointreel/package.h"
#include "tests/e2e/picture.h"
#include "tests/e2e/process.h"
#include "tests/read_file.h"
#include "tests/temporary_folder.h"

namespace pointreel::e2e::video_test {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

constexpr int kFrames = 10, kGroup = 4;

/// The voxels of a ball that moves, in two colours.
PointCloud ball(int frame) {
  PointCloud cloud;
  const glm::dvec3 center(70.0 + 2.0 * frame, 64.0, 60.0);
  for (int z = 0; z < 128; ++z) {
    for (int y = 0; y < 128; ++y) {
      for (int x = 0; x < 160; ++x) {
        const glm::dvec3 away = glm::dvec3(x, y, z) - center;
        if (std::abs(glm::length(away) - 45.0) > 0.6) continue;
        cloud.positions.emplace_back(x, y, z);
        cloud.normals.emplace_back(glm::normalize(away));
        cloud.colors.emplace_back(257 * 200, 257 * (away.y > 0 ? 180 : 40), 257 * 30);
      }
    }
  }
  return cloud;
}

class Video : public testing::Test {
 protected:
  void SetUp() override {
    fs::create_directory(folder_ / "in");
    for (int i = 0; i < kFrames; ++i)
      ASSERT_TRUE(write_ply(folder_ / "in" / (std::to_string(i) + ".ply"), ball(i)));
    const Outcome packed = pack("reel", {"--group", std::to_string(kGroup), "--segment", "8"});
    ASSERT_EQ(packed.exit_code, 0) << packed.err;
  }

  std::string path(const std::string& name) const { return (folder_ / name).string(); }
  static Outcome server(const std::vector<std::string>& arguments) {
    return run("pointreel-server", arguments);
  }
  Outcome pack(const std::string& reel, const std::vector<std::string>& more) const {
    std::vector<std::string> arguments{"pack",    "-i",    path("in"), "-o", path(reel),
                                       "--codec", "video", "--effort", "2"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return server(arguments);
  }
  PointCloud unpacked(const std::string& folder, int frame) const {
    char name[32];
    std::snprintf(name, sizeof name, "frame_%05d.ply", frame);
    const std::string bytes = read_file(fs::path(path(folder)) / name);
    return read_ply({reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()}).value();
  }

 private:
  const TemporaryFolder folder_;
};

TEST_F(Video, is_verified_unpacked_cut_and_joined) {
  EXPECT_EQ(server({"verify", path("reel")}).exit_code, 0);
  const Manifest manifest = read_manifest(path("reel")).value();
  EXPECT_EQ(manifest.codec, "video");
  EXPECT_EQ(manifest.group_frames, std::uint32_t{kGroup});
  EXPECT_FALSE(manifest.max_error) << "nobody measured it";
  EXPECT_EQ(nlohmann::json::parse(server({"info", path("reel"), "--json"}).out)["codec"], "video");

  // In the middle of a group, at its end, and the last one, in a segment of two frames.
  const Outcome done = server({"unpack", "-i", path("reel"), "-o", path("out")});
  ASSERT_EQ(done.exit_code, 0) << done.err;
  const CloudDistance compared = cloud_distance(ball(4), unpacked("out", 4)).value();
  ASSERT_TRUE(manifest.coding_error);
  EXPECT_EQ(manifest.coding_error->frames, 1u);
  EXPECT_NEAR(manifest.coding_error->d1, compared.d1(), 1e-3 * compared.d1());
  EXPECT_NEAR(*manifest.coding_error->luma, compared.colors()->x, 0.01 * compared.colors()->x);
  for (const int frame : {0, 3, 6, 9}) {
    const CloudDistance error = cloud_distance(ball(frame), unpacked("out", frame)).value();
    EXPECT_LT(std::sqrt(error.d1()), 1.0) << frame;
    EXPECT_GT(color_psnr(*error.colors()).x, 26.0) << frame;
    EXPECT_TRUE(std::ranges::none_of(unpacked("out", frame).normals, [](const glm::vec3& normal) {
      return normal == glm::vec3(0.0f);
    })) << frame;
  }
  const Outcome voxels =
      server({"unpack", "-i", path("reel"), "-o", path("voxels"), "--frames", "4", "--voxels"});
  ASSERT_EQ(voxels.exit_code, 0) << voxels.err;
  EXPECT_LT(cloud_distance(ball(4), unpacked("voxels", 4)).value().d1(), compared.d1());
  const Outcome of_base =
      server({"unpack", "-i", path("reel"), "-o", path("base"), "--layers", "1", "--voxels"});
  EXPECT_EQ(of_base.exit_code, 2);
  EXPECT_THAT(of_base.err, testing::HasSubstr("--voxels is for all layers of video"));
  const Outcome base = server({"unpack", "-i", path("reel"), "-o", path("base"), "--layers", "1"});
  ASSERT_EQ(base.exit_code, 0) << base.err;
  EXPECT_GT(unpacked("base", 6).size(), 1000u) << "octrees of their own";

  ASSERT_EQ(server({"cut", path("reel"), "-o", path("first"), "--frames", "0-7"}).exit_code, 0);
  ASSERT_EQ(server({"cut", path("reel"), "-o", path("second"), "--frames", "8-9"}).exit_code, 0);
  const Outcome joined = server(
      {"join", path("first"), path("second"), "-o", path("joined"), "--name", "a whole ball"});
  ASSERT_EQ(joined.exit_code, 0) << joined.err;
  EXPECT_EQ(read_manifest(path("first"))->name, "first");
  EXPECT_EQ(read_manifest(path("joined"))->name, "a whole ball");
  EXPECT_EQ(server({"verify", path("joined")}).exit_code, 0);

  // A cut within a group keeps what is needed to decode it, and does not show it.
  ASSERT_EQ(server({"cut", path("reel"), "-o", path("inner"), "--frames", "6-9"}).exit_code, 0);
  EXPECT_EQ(server({"verify", path("inner")}).exit_code, 0);
  const Manifest inner = read_manifest(path("inner")).value();
  EXPECT_EQ(inner.frame_count(), 6u);
  EXPECT_EQ(frame_at(inner, 0), 2u);
  EXPECT_THAT(server({"info", path("inner")}).out, HasSubstr("6 frames (4 of them shown)"));
  EXPECT_THAT(server({"unpack", path("inner"), path("four")}).out, HasSubstr("4 frames"));
  EXPECT_THAT(server({"unpack", path("inner"), path("two"), "--frames", "1-2"}).out,
              HasSubstr("2 frames"));
  EXPECT_EQ(unpacked("two", 1).size(), unpacked("four", 1).size());
  EXPECT_THAT(server({"cut", path("inner"), path("last"), "--frames", "2-3"}).out,
              HasSubstr("frames 2 to 3 of"));
  EXPECT_THAT(server({"info", path("last")}).out, HasSubstr("last: 2 frames"));
  for (const char* command : {"cut", "unpack"}) {
    EXPECT_NE(server({command, path("inner"), path("none"), "--frames", "3-4"}).exit_code, 0);
    EXPECT_FALSE(std::filesystem::exists(path("none")));
  }
  EXPECT_EQ(inner.duration_us, frame_time_us(manifest, 4));

  const std::string group = std::to_string(kGroup);
  ASSERT_EQ(pack("again", {"--group", group, "--segment", "8", "--threads", "1"}).exit_code, 0);
  const Manifest again = read_manifest(path("again")).value();
  for (std::size_t i = 0; i < manifest.segments.size(); ++i)
    EXPECT_EQ(manifest.segments[i].layers[1].checksum, again.segments[i].layers[1].checksum) << i;
}

TEST_F(Video, plays_and_damage_stays_in_its_group) {
  const auto play = [](const std::string& reel) {
    const Outcome all = run("pointreel", {"play", reel, "--renderer", "software", "--offscreen",
                                          "320x240", "--json", "-"});
    EXPECT_EQ(all.exit_code, 0) << all.err;
    return nlohmann::json::parse(all.out);
  };
  const auto report = play(path("reel"));
  EXPECT_EQ(report["errors"], 0);
  for (const auto& chosen : report["sources"][0]["chosen"])
    EXPECT_EQ(chosen["layers"], 2) << "however slow the machine is";
  EXPECT_EQ(report["frames_shown"].get<int>() + report["frames_dropped"].get<int>(), kFrames);
  // The octrees may be ready first, which are no more than a beginning.
  for (int time = 0; time < 5; ++time) {
    const Outcome drawn =
        run("pointreel", {"play", path("reel"), "--renderer", "software", "--offscreen", "400x400",
                          "--at", "0.2", "--screenshot", path("frame.png"), "--json", "-"});
    ASSERT_EQ(drawn.exit_code, 0) << drawn.err;
    EXPECT_EQ(nlohmann::json::parse(drawn.out)["layers"], 2);
  }
  const Picture picture = read_picture(path("frame.png"));
  EXPECT_GT(find_hue(picture, {1, 1, 0}).pixels, 2000u) << "the upper half is yellow";
  EXPECT_GT(find_hue(picture, {1, 0, 0}).pixels, 2000u) << "the lower half is red";

  fs::copy(path("reel"), path("damaged"));
  const LayerFile file = read_manifest(path("reel")).value().segments[0].layers[1];
  std::fstream stream(fs::path(path("damaged")) / file.path,
                      std::ios::in | std::ios::out | std::ios::binary);
  stream.seekp(static_cast<std::streamoff>(byte_range(file, 5).offset + 60));
  stream.put('\x5a');
  stream.close();
  const Outcome verified = server({"verify", path("damaged")});
  EXPECT_EQ(verified.exit_code, 1);
  EXPECT_THAT(verified.out + verified.err, HasSubstr("frames 5 to 7"));
  EXPECT_THAT(verified.out + verified.err, testing::Not(HasSubstr("frame 4")));
  EXPECT_GT(play(path("damaged"))["errors"].get<int>(), 0);
}

TEST_F(Video, colours_that_some_frames_lack_are_kept_and_empty_frames_have_none) {
  PointCloud plain = ball(1);
  plain.colors.clear();
  const PointCloud nothing;
  for (const bool colored : {true, false}) {
    const std::string in = colored ? "mixed" : "plain";
    fs::create_directory(path(in));
    ASSERT_TRUE(write_ply(path(in) + "/0.ply", colored ? ball(0) : plain));
    ASSERT_TRUE(write_ply(path(in) + "/1.ply", colored ? plain : nothing));
    const Outcome packed = server(
        {"pack", "-i", path(in), "-o", path(in) + ".reel", "--codec", "video", "--effort", "0"});
    ASSERT_EQ(packed.exit_code, 0) << packed.err;
    EXPECT_EQ(server({"verify", path(in) + ".reel"}).exit_code, 0);
    ASSERT_EQ(server({"unpack", "-i", path(in) + ".reel", "-o", path(in) + ".out"}).exit_code, 0);
    EXPECT_EQ(unpacked(in + ".out", 0).has_colors(), colored);
  }
}

TEST_F(Video, keeps_within_a_bit_rate) {
  const auto rate_of = [&](const std::string& reel, const std::vector<std::string>& options) {
    const Outcome packed = pack(reel, options);
    EXPECT_EQ(packed.exit_code, 0) << packed.err;
    const Manifest manifest = read_manifest(path(reel)).value();
    std::uint64_t bytes = 0;
    for (const PackageFile* file : manifest.files()) bytes += file->bytes;
    return static_cast<double>(bytes) * 8e6 / static_cast<double>(manifest.duration_us);
  };
  const double coarsest = rate_of("coarse", {"--quality", "1"}), free = rate_of("free", {});
  const double asked = std::sqrt(coarsest * free);
  const double rate = rate_of("bound", {"--bitrate", std::to_string(static_cast<int>(asked))});
  EXPECT_LE(rate, asked);
  EXPECT_GT(rate, 0.6 * asked);
  EXPECT_EQ(server({"verify", path("bound")}).exit_code, 0);

  const std::string too_few = std::to_string(static_cast<int>(0.5 * coarsest));
  const Outcome refused = pack("never", {"--bitrate", too_few});
  EXPECT_EQ(refused.exit_code, 1);
  EXPECT_THAT(refused.err, HasSubstr("at the coarsest, more than the bit rate"));
  EXPECT_FALSE(fs::exists(path("never")));
}

TEST_F(Video, a_frame_that_collapses_is_an_error_or_a_warning) {
  fs::create_directory(path("far"));
  PointCloud far = ball(0);
  far.positions[0] = glm::vec3(1e6f, 0.0f, 0.5f);
  ASSERT_TRUE(write_ply(path("far") + "/0.ply", far));
  std::vector<std::string> arguments{"pack",    "-i",    path("far"), "-o",  path("far") + ".reel",
                                     "--codec", "video", "--clean",   "off", "--effort",
                                     "0"};
  const Outcome refused = server(arguments);
  EXPECT_EQ(refused.exit_code, 1);
  EXPECT_THAT(refused.err, HasSubstr("0.ply: its "));
  EXPECT_THAT(refused.err, HasSubstr("points collapse into pixels"));
  EXPECT_THAT(refused.err, HasSubstr("some lie too far away, such as the point at 1000000 0 0.5"));

  // No point of a sparse scan is to blame.
  const Outcome made =
      run("pointreel-synth", {"kick", "--points", "800", "--frames", "6", "-o", path("sparse")});
  ASSERT_EQ(made.exit_code, 0) << made.err;
  const Outcome few = server({"pack", path("sparse"), path("sparse.reel"), "--codec", "video"});
  EXPECT_EQ(few.exit_code, 1) << few.out;
  EXPECT_THAT(few.err, HasSubstr("because they are too few for video"));
}

TEST_F(Video, options_that_do_not_go_together_are_refused) {
  for (const auto& [options, message] :
       std::vector<std::pair<std::vector<std::string>, std::string>>{
           {{"--cube", "frame"}, "--cube frame does not go with --codec video"},
           {{"--voxel", "2"}, "--voxel needs --codec octree"}}) {
    const Outcome refused = pack("never", options);
    EXPECT_EQ(refused.exit_code, 2);
    EXPECT_THAT(refused.err, HasSubstr(message));
  }
  const Outcome octree = server({"pack", "-i", path("in"), "-o", path("never"), "--group", "8"});
  EXPECT_EQ(octree.exit_code, 2);
  EXPECT_THAT(octree.err, HasSubstr("--group needs --codec video"));
}

}  // namespace
}  // namespace pointreel::e2e::video_test
