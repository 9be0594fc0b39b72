// pointreel-bench compare, run as a user runs it, on clouds whose errors are known.

#include <filesystem>
#include <fstream>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "codec/files/ply.h"
#include "tests/e2e/process.h"
#include "tests/paths.h"
#include "tests/temporary_folder.h"

namespace pointreel::e2e::compare_test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::HasSubstr;
using testing::Not;

/// A square of 32 x 32 points one unit apart, at height z, which faces up.
PointCloud plane(float z, int red) {
  PointCloud cloud;
  for (int i = 0; i < 1024; ++i) {
    cloud.positions.emplace_back(static_cast<float>(i % 32), static_cast<float>(i / 32), z);
    cloud.normals.emplace_back(0, 0, 1);
    cloud.colors.push_back(glm::u16vec3(red, 50, 50) * std::uint16_t{257});
  }
  return cloud;
}

class Compare : public testing::Test {
 protected:
  void SetUp() override {
    ASSERT_TRUE(write_ply(path("a.ply"), plane(0.0f, 100)));
    ASSERT_TRUE(write_ply(path("b.ply"), plane(0.5f, 110)));
  }

  std::string path(const std::string& name) const { return (folder_ / name).string(); }

  Outcome compare(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), "compare");
    return run("pointreel-bench", arguments);
  }

  TemporaryFolder folder_;
};

TEST_F(Compare, reports_known_errors_in_units_voxels_and_decibels) {
  const Outcome outcome = compare(
      {path("a.ply"), path("b.ply"), "--peak", "31", "--bits", "5", "--json", path("report.json")});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_EQ(outcome.err, "");
  for (const char* part : {"1,024 points", "D1 root mean square", "D2 PSNR", "maximum distance",
                           "voxels", "colour PSNR Y", "colour PSNR 6:1:1", "normals 95 %"}) {
    EXPECT_THAT(outcome.out, HasSubstr(part));
  }
  const json report = json::parse(std::ifstream(path("report.json")));
  EXPECT_EQ(report.at("peak"), 31.0);
  EXPECT_EQ(report.at("voxel"), 1.0);
  EXPECT_EQ(report.at("a").at("points"), 1024);
  for (const char* direction : {"a_to_b", "b_to_a", "symmetric"}) {
    const json& errors = report.at(direction);
    EXPECT_EQ(errors.at("d1"), 0.25);
    EXPECT_EQ(errors.at("d2"), 0.25);
    EXPECT_EQ(errors.at("max"), 0.5);
    EXPECT_NEAR(errors.at("d1_psnr").get<double>(), 40.6192, 1e-3);
    EXPECT_NEAR(errors.at("color_psnr").at("y").get<double>(), 41.5790, 1e-3);
    EXPECT_EQ(errors.at("normals").at("mean_degrees"), 0.0);
  }
}

TEST_F(Compare, writes_an_infinite_psnr_as_null_in_json) {
  const Outcome outcome = compare({path("a.ply"), path("a.ply"), "--json"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const json report = json::parse(outcome.out);  // without a table
  EXPECT_EQ(report.at("peak"), 31.0);
  EXPECT_FALSE(report.contains("voxel"));
  EXPECT_EQ(report.at("symmetric").at("d1"), 0.0);
  EXPECT_TRUE(report.at("symmetric").at("d1_psnr").is_null());
  EXPECT_TRUE(report.at("symmetric").at("color_psnr").at("cr").is_null());
}

TEST_F(Compare, takes_integer_coordinates_for_voxels_if_the_bits_are_given) {
  const Outcome whole = compare({path("a.ply"), path("b.ply"), "--bits", "6", "--json", "-"});
  EXPECT_EQ(json::parse(whole.out).at("peak"), 63.0);
  EXPECT_EQ(json::parse(whole.out).at("voxel"), 1.0);
  // Coordinates at half heights are not voxels: the largest extent, 31, is divided into 63 voxels.
  const Outcome parts = compare({path("b.ply"), path("a.ply"), "--bits", "6", "--json", "-"});
  EXPECT_EQ(json::parse(parts.out).at("peak"), 31.0);
  EXPECT_NEAR(json::parse(parts.out).at("voxel").get<double>(), 31.0 / 63.0, 1e-12);
}

TEST_F(Compare, omits_rows_of_attributes_that_the_clouds_lack) {
  PointCloud bare = plane(0.0f, 0);
  bare.normals.clear();
  bare.colors.clear();
  ASSERT_TRUE(write_ply(path("bare.ply"), bare));
  const Outcome outcome = compare({path("bare.ply"), path("bare.ply")});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("largest extent of a"));
  for (const char* part : {"D2", "colour", "normals", "voxel"}) {
    EXPECT_THAT(outcome.out, Not(HasSubstr(part)));
  }
}

TEST_F(Compare, reads_drc_files) {
  const std::string file = source_folder() / "tests/fuzz/corpus/drc/cloud_sequential.drc";
  const Outcome outcome = compare({file, file, "--json", "-"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_EQ(json::parse(outcome.out).at("symmetric").at("max"), 0.0);
}

TEST_F(Compare, reports_an_error_in_one_line) {
  ASSERT_TRUE(write_ply(path("empty.ply"), PointCloud{}));
  folder_.write("noise.ply", "noise");
  for (const char* bad : {"empty.ply", "noise.ply", "missing.ply"}) {
    const Outcome outcome = compare({path("a.ply"), path(bad)});
    EXPECT_EQ(outcome.exit_code, 1) << bad;
    EXPECT_THAT(outcome.err, HasSubstr(bad));
    EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
  }
  EXPECT_EQ(compare({path("a.ply"), path("b.ply"), "--json", path("no/report.json")}).exit_code, 1);
  EXPECT_EQ(compare({path("a.ply")}).exit_code, 2);
  EXPECT_EQ(compare({path("a.ply"), path("b.ply"), "--peak", "-1"}).exit_code, 2);
}

}  // namespace
}  // namespace pointreel::e2e::compare_test
