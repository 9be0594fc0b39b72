// The trade-offs between size, time and accuracy that a user can choose on the command lines.

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <string>
#include <tuple>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "codec/distance/distance.h"
#include "codec/files/cloud_file.h"
#include "codec/files/ply.h"
#include "tests/e2e/process.h"
#include "tests/temporary_folder.h"

namespace pointreel::e2e::control_test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr int kFrames = 3;

/// A wavy sheet far from the origin, whose colour changes from one side to the other.
PointCloud sheet(int frame) {
  PointCloud cloud;
  cloud.origin = {3e5, -1e5, 50.0};
  constexpr int kSide = 140;
  for (int i = 0; i < kSide * kSide; ++i) {
    // The points lie in pairs that only depth 11 is certain to separate.
    const int column = i % kSide;
    const float x = (static_cast<float>(column) - 0.9f * static_cast<float>(column % 2)) / kSide;
    const float y = static_cast<float>(i / kSide) / kSide;
    const float phase = 9.0f * x + 5.0f * y + 0.2f * static_cast<float>(frame);
    cloud.positions.emplace_back(x, y, 0.1f * std::sin(phase));
    cloud.normals.push_back(
        glm::normalize(glm::vec3(-0.9f * std::cos(phase), -0.5f * std::cos(phase), 1.0f)));
    cloud.colors.emplace_back(static_cast<int>(60000.0f * x), static_cast<int>(50000.0f * y),
                              20000);
  }
  return cloud;
}

class Control : public testing::Test {
 protected:
  void SetUp() override {
    fs::create_directories(folder_ / "in");
    for (int i = 0; i < kFrames; ++i) {
      ASSERT_TRUE(write_ply(folder_ / fmt::format("in/{}.ply", i), sheet(i)));
    }
  }

  fs::path reel() const { return folder_ / "reel"; }

  json pack(std::vector<std::string> more) {
    std::vector<std::string> all = {
        "pack", "-i", (folder_ / "in").string(), "-o", reel().string(), "--force", "--json"};
    all.insert(all.end(), more.begin(), more.end());
    const Outcome packed = run("pointreel-server", all);
    EXPECT_EQ(packed.exit_code, 0) << packed.err;
    return json::parse(packed.out, nullptr, false);
  }

  PointCloud unpacked(const std::vector<std::string>& more, int frame = 1) {
    std::vector<std::string> all = {
        "unpack", "-i", reel().string(), "-o", (folder_ / "out").string(), "--force"};
    all.insert(all.end(), more.begin(), more.end());
    const Outcome done = run("pointreel-server", all);
    EXPECT_EQ(done.exit_code, 0) << done.err;
    const auto cloud = read_cloud_file(folder_ / fmt::format("out/frame_{:05}.ply", frame));
    EXPECT_TRUE(cloud) << cloud.error().message;
    return cloud ? cloud->cloud : PointCloud{};
  }

  json played(const std::vector<std::string>& more) {
    const fs::path report = folder_ / "play.json";
    std::vector<std::string> all = {"play",  reel().string(), "--offscreen",
                                    "96x72", "--json",        report.string()};
    all.insert(all.end(), more.begin(), more.end());
    const Outcome done = run("pointreel", all);
    EXPECT_EQ(done.exit_code, 0) << done.err;
    std::ifstream in(report);
    return json::parse(in, nullptr, false);
  }

  TemporaryFolder folder_;
};

using Place = std::tuple<double, double, double>;

/// The index of each point by its place, rounded to a micrometre.
std::map<Place, std::size_t> by_place(const PointCloud& cloud) {
  std::map<Place, std::size_t> places;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const glm::dvec3 p = glm::round(cloud.world(i) * 1e6);
    places[{p.x, p.y, p.z}] = i;
  }
  return places;
}

TEST_F(Control, fewer_layers_give_a_coarser_octree_with_mean_attributes) {
  pack({"--depth", "10", "--quality", "100"});
  const PointCloud base = unpacked({"--layers", "1"}), middle = unpacked({"--layers", "2"});
  const PointCloud full = unpacked({"--layers", "3"});
  EXPECT_EQ(unpacked({}).positions, full.positions);
  EXPECT_LT(base.size(), middle.size());
  EXPECT_LT(middle.size(), full.size());
  for (const auto& [depth, coarse] : {std::pair{7, &base}, {9, &middle}}) {
    pack({"--depth", std::to_string(depth), "--quality", "100"});
    const PointCloud packed_so = unpacked({});
    const auto places = by_place(*coarse), expected = by_place(packed_so);
    ASSERT_EQ(places.size(), coarse->size());
    ASSERT_EQ(places.size(), expected.size());
    for (const auto& [place, i] : places) {
      const auto found = expected.find(place);
      ASSERT_NE(found, expected.end());
      // The colour is a mean of means: it weighs voxels, not the points in them.
      const glm::ivec3 difference(glm::ivec3(coarse->colors[i]) -
                                  glm::ivec3(packed_so.colors[found->second]));
      EXPECT_LE(glm::length(glm::vec3(difference)), 2.0 * 257.0);
      EXPECT_GT(glm::dot(coarse->normals[i], packed_so.normals[found->second]), 0.99f);
    }
  }
}

TEST_F(Control, playing_fewer_layers_fetches_fewer_bytes_and_draws_a_coarser_octree) {
  pack({"--depth", "10"});
  json before;
  for (const int layers : {1, 2, 3}) {
    // Point mode, because voxel mode would fill the gaps between voxels.
    const json report = played({"--layers", std::to_string(layers), "--mode", "point", "--delta",
                                "0", "--pixel-size", "0"});
    EXPECT_EQ(report["layers"], layers);
    EXPECT_EQ(report["frames_shown"], kFrames);
    EXPECT_EQ(report["depth"], layers == 1 ? 7 : layers == 2 ? 9 : 10);
    if (!before.is_null()) {
      EXPECT_GT(report["fetched_bytes"], before["fetched_bytes"]);
      EXPECT_GT(report["leaves"], before["leaves"]);
    }
    before = report;
  }
  const json all = played({"--mode", "point", "--delta", "0", "--pixel-size", "0"});
  EXPECT_EQ(all["fetched_bytes"], before["fetched_bytes"]);
  EXPECT_EQ(played({"--layers", "9", "--mode", "point", "--pixel-size", "0"})["layers"], 3);
}

TEST_F(Control, playing_fetches_only_what_the_mode_and_view_show_and_reports_the_rest) {
  pack({"--depth", "10"});
  for (const std::string mode : {"surfel", "voxel", "point"}) {
    const json fine = played({"--mode", mode, "--delta", "0", "--pixel-size", "0"});
    const json small = played({"--mode", mode, "--delta", "0"});
    EXPECT_EQ(fine["layers"], 3);
    EXPECT_EQ(small["layers"], 1) << "a small picture needs one layer";
    EXPECT_EQ(fine["skipped"]["layers"], 0);
    EXPECT_EQ(small["skipped"]["layers"], 2);
    EXPECT_EQ(small["skipped"]["levels"], 3);
    EXPECT_GT(small["skipped"]["bytes"], fine["skipped"]["bytes"]);
    EXPECT_EQ(small["skipped"]["bytes"].get<int>() + small["fetched_bytes"].get<int>(),
              fine["skipped"]["bytes"].get<int>() + fine["fetched_bytes"].get<int>());
    EXPECT_EQ(fine["skipped"]["attributes"].size(), mode == "surfel" ? 0u : 1u);
    EXPECT_EQ(fine["drawn"], fine["leaves"]);
    // Between coarse voxels gaps are filled, which may take more voxels than there are points.
    if (mode != "voxel") {
      EXPECT_LT(small["drawn"], fine["drawn"]);
    }
    EXPECT_EQ(small["frames_shown"], kFrames);
    EXPECT_EQ(small["frames_refined"], 0);
  }
}

TEST_F(Control, a_bit_rate_is_kept_and_its_cost_is_reported) {
  const json free = pack({"--fps", "10"});
  const double free_rate = free["segments"][0]["bits_per_second"];
  const json bound = pack({"--fps", "10", "--bitrate", fmt::format("{:.0f}k", free_rate / 4e3)});
  const json& segment = bound["segments"][0];
  std::uint64_t bytes = 0;
  for (const auto& entry : fs::directory_iterator(reel())) {
    if (entry.path().extension() == ".prs") bytes += entry.file_size();
  }
  EXPECT_EQ(segment["bytes"], bytes);
  EXPECT_LE(8.0 * static_cast<double>(bytes) * 10.0 / kFrames, free_rate / 4.0 + 1000.0);
  EXPECT_LT(segment["depth"]["max"], free["segments"][0]["depth"]["max"]);
  EXPECT_GT(bound["max_error"], free["max_error"]);
  EXPECT_EQ(run("pointreel-server", {"verify", reel().string()}).exit_code, 0);
}

TEST_F(Control, no_point_is_displaced_by_more_than_the_package_states) {
  for (const std::vector<std::string>& options :
       {std::vector<std::string>{"--delta", "0.2"},
        {"--codec", "draco", "--qp", "9"},
        {"--codec", "draco", "--qp", "12", "--method", "sequential"}}) {
    const json summary = pack(options);
    const Outcome info = run("pointreel-server", {"info", reel().string(), "--json"});
    const double told = json::parse(info.out)["max_error"];
    EXPECT_EQ(summary["max_error"], told);
    const auto source = read_cloud_file(folder_ / "in/1.ply");
    ASSERT_TRUE(source);
    const double most = cloud_distance(source->cloud, unpacked({}))->max();
    EXPECT_LE(most, told);
    EXPECT_GT(most, 0.5 * told);
  }
}

TEST_F(Control, a_limit_on_the_time_for_a_frame_lowers_the_depth) {
  const json summary = pack({"--frame-time", "0.000001", "--threads", "1"});
  EXPECT_EQ(summary["late_frames"], kFrames);
  EXPECT_EQ(summary["depth"]["min"], 1);
}

TEST_F(Control, every_error_is_printed_in_one_line) {
  const std::vector<std::vector<std::string>> wrong = {
      {"--bitrate", "fast"}, {"--frame-time", "-1"}, {"--codec", "draco", "--method", "octree"}};
  for (const std::vector<std::string>& options : wrong) {
    std::vector<std::string> all = {"pack", "-i", (folder_ / "in").string(), "-o", reel().string()};
    all.insert(all.end(), options.begin(), options.end());
    const Outcome outcome = run("pointreel-server", all);
    EXPECT_EQ(outcome.exit_code, 2);
    EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
    EXPECT_FALSE(fs::exists(reel()));
  }
  const Outcome layers = run("pointreel", {"play", "x", "--layers", "0"});
  EXPECT_EQ(layers.exit_code, 2);
  EXPECT_EQ(std::count(layers.err.begin(), layers.err.end(), '\n'), 1) << layers.err;
}

}  // namespace
}  // namespace pointreel::e2e::control_test
