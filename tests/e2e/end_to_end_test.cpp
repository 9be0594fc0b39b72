#include <algorithm>
#include <cmath>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <set>
#include <tuple>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "codec/core/build.h"
#include "codec/distance/distance.h"
#include "codec/files/cloud_file.h"
#include "codec/files/cloud_folder.h"
#include "codec/files/ply.h"
#include "pointreel/octree.h"
#include "tests/e2e/picture.h"
#include "tests/e2e/process.h"
#include "tests/e2e/server_address.h"
#include "tests/temporary_folder.h"

namespace pointreel::e2e::end_to_end_test {
namespace {

namespace fs = std::filesystem;

constexpr int kFrames = 4;
constexpr int kDepth = 9;
constexpr double kFps = 10.0;

void add_ball(PointCloud& cloud, const glm::vec3& center, float radius, const glm::u8vec3& color) {
  constexpr int kRings = 60;
  for (int ring = 0; ring <= kRings; ++ring) {
    const float polar = 3.14159265f * static_cast<float>(ring) / kRings;
    const int steps = std::max(1, static_cast<int>(2 * kRings * std::sin(polar)));
    for (int step = 0; step < steps; ++step) {
      const float turn = 6.2831853f * static_cast<float>(step) / static_cast<float>(steps);
      const glm::vec3 n(std::sin(polar) * std::cos(turn), std::cos(polar),
                        std::sin(polar) * std::sin(turn));
      cloud.positions.push_back(center + radius * n);
      cloud.normals.push_back(n);
      cloud.colors.push_back(glm::u16vec3(color) * std::uint16_t{257});
    }
  }
}

/// A scene in which every axis and every frame looks different. Seen from the front (along -z), red
/// is on the right, green at the top and blue on the left. Yellow moves from left to right below.
PointCloud scene(int frame) {
  PointCloud cloud;
  cloud.origin = {500'000.0, -20.0, 0.25};
  add_ball(cloud, {1.0f, 0.0f, 0.0f}, 0.35f, {230, 20, 20});
  add_ball(cloud, {0.0f, 1.0f, 0.0f}, 0.35f, {20, 230, 20});
  add_ball(cloud, {-1.0f, 0.0f, 0.0f}, 0.35f, {20, 20, 230});
  add_ball(cloud, {-0.9f + 0.6f * static_cast<float>(frame), -1.0f, 0.0f}, 0.25f, {230, 230, 20});
  return cloud;
}

class EndToEnd : public testing::TestWithParam<const char*> {
 protected:
  void SetUp() override {
    fs::create_directories(folder_ / "in");
    for (int i = 0; i < kFrames; ++i) {
      // The order is natural: frame2 comes before frame10.
      ASSERT_TRUE(write_ply(folder_ / fmt::format("in/frame{}.ply", i * 5), scene(i)));
    }
  }

  Outcome pack() {
    std::vector<std::string> arguments = {"pack",
                                          "-i",
                                          (folder_ / "in").string(),
                                          "-o",
                                          reel().string(),
                                          "--codec",
                                          GetParam(),
                                          draco() ? "--qp" : "--depth",
                                          std::to_string(kDepth),
                                          "--fps",
                                          std::to_string(kFps),
                                          "--json"};
    if (draco()) arguments.push_back("--measure-parts");
    return run("pointreel-server", arguments);
  }

  bool draco() const { return GetParam() == std::string("draco"); }
  fs::path reel() const { return folder_ / "reel"; }

  TemporaryFolder folder_;
};
INSTANTIATE_TEST_SUITE_P(Codecs, EndToEnd, testing::Values("octree", "draco"),
                         [](const auto& codec) { return std::string(codec.param); });

using Cell = std::tuple<unsigned, unsigned, unsigned>;

std::set<Cell> cells_of(const PointCloud& cloud, const Cube& cube) {
  std::set<Cell> cells;
  for (const glm::uvec3& c : leaf_cells(build_svo(sort_points(cloud, cube), kDepth))) {
    cells.insert({c.x, c.y, c.z});
  }
  return cells;
}

TEST_P(EndToEnd, unpacking_restores_every_voxel_at_its_original_place) {
  const Outcome packed = pack();
  ASSERT_EQ(packed.exit_code, 0) << packed.err;
  const auto summary = nlohmann::json::parse(packed.out, nullptr, false);
  ASSERT_FALSE(summary.is_discarded()) << packed.out;
  EXPECT_EQ(summary["frames"], kFrames);
  EXPECT_GT(summary["bits_per_point"]["geometry"], 0.0);
  EXPECT_GT(summary["bits_per_point"]["colors"], 0.0);
  EXPECT_GT(summary["bits_per_point"]["normals"], 0.0);
  EXPECT_LE(summary["encode_ms"]["min"], summary["encode_ms"]["median"]);

  EXPECT_EQ(run("pointreel-server", {"verify", reel().string()}).exit_code, 0);
  const Outcome unpacked =
      run("pointreel-server", {"unpack", "-i", reel().string(), "-o", (folder_ / "out").string()});
  ASSERT_EQ(unpacked.exit_code, 0) << unpacked.err;

  // The originals as pack reads them: the coordinates in a file are rounded relative to another
  // origin than those of the scene.
  std::vector<PointCloud> originals;
  Box box;
  for (int i = 0; i < kFrames; ++i) {
    auto original = read_cloud_file(folder_ / fmt::format("in/frame{}.ply", i * 5));
    ASSERT_TRUE(original) << original.error().message;
    originals.push_back(std::move(original->cloud));
    box.grow(bounds(originals.back()));
  }
  const Cube cube = bounding_cube(box);
  const double cell = std::ldexp(cube.edge, -kDepth);
  const auto files = list_cloud_files({folder_ / "out"});
  ASSERT_TRUE(files);
  ASSERT_EQ(files->size(), static_cast<std::size_t>(kFrames));
  for (int i = 0; i < kFrames; ++i) {
    const auto frame = read_cloud_file((*files)[static_cast<std::size_t>(i)]);
    ASSERT_TRUE(frame) << frame.error().message;
    const PointCloud& original = originals[static_cast<std::size_t>(i)];
    EXPECT_TRUE(cells_of(frame->cloud, cube) == cells_of(original, cube)) << "frame " << i;
    // Half a voxel's diagonal, plus the precision of a double at this origin.
    const auto distance = cloud_distance(original, frame->cloud);
    ASSERT_TRUE(distance);
    EXPECT_LE(distance->max(), 0.5 * std::sqrt(3.0) * cell + 1e-9);
    EXPECT_TRUE(frame->cloud.has_normals());
  }
}

TEST_P(EndToEnd, a_reel_over_http_shows_the_right_frame_upright_and_in_colour) {
  const Outcome packed = pack();
  ASSERT_EQ(packed.exit_code, 0) << packed.err;
  Background server("pointreel-server", {"serve", reel().string(), "--listen", "127.0.0.1:0"});
  const std::string address = server_address(server);
  ASSERT_FALSE(address.empty());

  for (const std::string mode : {"surfel", "voxel", "point"}) {
    double yellow_before = -1.0;
    for (int frame = 0; frame < kFrames; ++frame) {
      SCOPED_TRACE(fmt::format("{} mode, frame {}", mode, frame));
      const fs::path png = folder_ / fmt::format("{}{}.png", mode, frame);
      const fs::path json = folder_ / "play.json";
      const Outcome played =
          run("pointreel", {"play", "http://" + address + "/reel", "--mode", mode, "--offscreen",
                            "320x240", "--at", fmt::format("{}", (frame + 0.5) / kFps), "--view",
                            "front", "--screenshot", png.string(), "--json", json.string()});
      ASSERT_EQ(played.exit_code, 0) << played.err;

      const Picture picture = read_picture(png);
      ASSERT_EQ(picture.size, glm::ivec2(320, 240));
      const Patch red = find_hue(picture, {1, 0, 0}), green = find_hue(picture, {0, 1, 0});
      const Patch blue = find_hue(picture, {0, 0, 1}), yellow = find_hue(picture, {1, 1, 0});
      for (const Patch& patch : {red, green, blue, yellow}) ASSERT_GT(patch.pixels, 100u);
      EXPECT_LT(blue.center.x + 40, green.center.x);
      EXPECT_LT(green.center.x + 40, red.center.x);
      EXPECT_LT(green.center.y + 30, red.center.y);
      EXPECT_LT(red.center.y + 30, yellow.center.y);
      EXPECT_NEAR(green.center.x, 160, 8);
      // In each frame, the moving ball is further to the right, by 0.6 of the 2.7 units of the
      // scene's width.
      if (frame > 0) {
        EXPECT_GT(yellow.center.x, yellow_before + 15);
      }
      yellow_before = yellow.center.x;
    }
  }
  EXPECT_EQ(server.end(SIGTERM), 0);
}

TEST_P(EndToEnd, playing_all_frames_shows_each_once_and_reports_every_stage) {
  ASSERT_EQ(pack().exit_code, 0);
  const fs::path json = folder_ / "play.json";
  const Outcome played = run("pointreel", {"play", reel().string(), "--offscreen", "160x120",
                                           "--mode", "voxel", "--json", json.string()});
  ASSERT_EQ(played.exit_code, 0) << played.err;
  std::ifstream file(json);
  const auto report = nlohmann::json::parse(file, nullptr, false);
  ASSERT_FALSE(report.is_discarded());
  EXPECT_EQ(report["frames_shown"], kFrames);
  EXPECT_EQ(report["frames_dropped"], 0);
  for (const char* stage : {"fetch_ms", "decode_ms", "svo_ms", "cut_ms", "render_ms"}) {
    ASSERT_TRUE(report.contains(stage)) << stage;
    EXPECT_LE(report[stage]["median"], report[stage]["p95"]) << stage;
    EXPECT_LE(report[stage]["p95"], report[stage]["max"]) << stage;
  }
  for (const char* count : {"points", "nodes", "leaves", "depth", "drawn"}) {
    EXPECT_GT(report[count], 0) << count;
  }
}

TEST_P(EndToEnd, a_damaged_segment_is_found_and_named) {
  ASSERT_EQ(pack().exit_code, 0);
  fs::path largest;
  for (const auto& entry : fs::directory_iterator(reel())) {
    if (entry.path().filename() == "reel.json") continue;
    if (largest.empty() || entry.file_size() > fs::file_size(largest)) largest = entry.path();
  }
  std::fstream file(largest, std::ios::in | std::ios::out | std::ios::binary);
  file.seekg(static_cast<std::streamoff>(fs::file_size(largest) / 2));
  const char byte = static_cast<char>(file.get());
  file.seekp(static_cast<std::streamoff>(fs::file_size(largest) / 2));
  file.put(static_cast<char>(byte ^ 0x10));
  file.close();
  const Outcome verified = run("pointreel-server", {"verify", reel().string()});
  EXPECT_EQ(verified.exit_code, 1);
  EXPECT_NE((verified.out + verified.err).find(largest.filename().string()), std::string::npos)
      << verified.out << verified.err;
  fs::remove(largest);
  const std::string missing = run("pointreel-server", {"verify", reel().string()}).out;
  EXPECT_LE(std::count(missing.begin(), missing.end(), '\n'), 3) << "frames with the same fault";
}

TEST(EndToEndErrors, are_printed_in_one_line_that_names_the_problem_and_its_place) {
  const auto one_line = [](const Outcome& outcome) {
    return outcome.exit_code != 0 && std::count(outcome.err.begin(), outcome.err.end(), '\n') == 1;
  };
  const Outcome nothing =
      run("pointreel-server", {"pack", "-i", "/no/such/folder", "-o", "/tmp/x"});
  EXPECT_TRUE(one_line(nothing)) << nothing.err;
  EXPECT_NE(nothing.err.find("/no/such/folder"), std::string::npos);
  const Outcome unreachable =
      run("pointreel", {"play", "http://127.0.0.1:1/reel", "--offscreen", "64x64", "--at", "0"});
  EXPECT_TRUE(one_line(unreachable)) << unreachable.err;
  EXPECT_NE(unreachable.err.find("127.0.0.1:1"), std::string::npos) << unreachable.err;
  const TemporaryFolder folder;
  std::ofstream(folder / "a.txt") << "no package";
  const Outcome no_package =
      run("pointreel-server", {"serve", folder.path().string(), "--listen", "127.0.0.1:0"});
  EXPECT_TRUE(one_line(no_package)) << no_package.err;
  EXPECT_NE(no_package.err.find(folder.path().string()), std::string::npos) << no_package.err;
}

}  // namespace
}  // namespace pointreel::e2e::end_to_end_test
