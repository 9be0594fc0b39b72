#include "datasets_synthetic/hard_cases.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <set>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "codec/core/build.h"
#include "codec/files/cloud_file.h"
#include "codec/package/manifest.h"
#include "pointreel/octree.h"
#include "server/commands/commands.h"
#include "tests/packed_reel.h"

namespace pointreel::hard_cases_test {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::SizeIs;
using testing::StartsWith;

/// Writes the case's file into the folder.
std::filesystem::path write(const TemporaryFolder& folder, const HardCase& hard) {
  const std::filesystem::path path = folder.path() / hard.file;
  write_file(path, hard.bytes);
  return path;
}

std::vector<std::string> warnings_of(const HardExpectation& expect) {
  std::vector<std::string> parts;
  if (!expect.cut_at.empty()) parts.push_back("the data end|" + expect.cut_at);
  for (const auto& [count, what] : {std::pair{expect.dropped, "without a finite position"},
                                    std::pair{expect.unknown_normals, "no usable normal"},
                                    std::pair{expect.bad_radii, "unusable radius"}}) {
    if (count > 0) parts.push_back(std::to_string(count) + "|" + what);
  }
  return parts;
}

void expect_error(const std::filesystem::path& path, const std::vector<std::string>& names) {
  const Result<LoadedCloud> loaded = read_cloud_file(path);
  ASSERT_FALSE(loaded.has_value());
  const std::string& message = loaded.error().message;
  EXPECT_THAT(message, StartsWith(path.string() + ": "));
  for (const char c : message) EXPECT_TRUE(c >= ' ' && c <= '~') << message;
  const std::string rest = message.substr(path.string().size());
  for (const std::string& name : names) EXPECT_THAT(rest, HasSubstr(name));
}

void expect_cloud(const std::filesystem::path& path, const HardExpectation& expect) {
  const Result<LoadedCloud> loaded = read_cloud_file(path);
  ASSERT_TRUE(loaded.has_value()) << loaded.error().message;
  const PointCloud& cloud = loaded->cloud;
  EXPECT_THAT(cloud.positions, SizeIs(expect.points));
  EXPECT_THAT(cloud.normals, SizeIs(expect.normals ? expect.points : 0));
  EXPECT_THAT(cloud.colors, SizeIs(expect.colors ? expect.points : 0));
  EXPECT_THAT(cloud.radii, SizeIs(expect.radii ? expect.points : 0));

  const std::vector<std::string> warnings = warnings_of(expect);
  ASSERT_THAT(loaded->warnings, SizeIs(warnings.size()));
  for (std::size_t i = 0; i < warnings.size(); ++i) {
    const std::size_t bar = warnings[i].find('|');
    EXPECT_THAT(loaded->warnings[i], AllOf(HasSubstr(warnings[i].substr(0, bar)),
                                           HasSubstr(warnings[i].substr(bar + 1))));
  }

  const Box box = bounds(cloud);
  ASSERT_EQ(box.empty(), expect.bounds.empty());
  for (int axis = 0; axis < 3 && !box.empty(); ++axis) {
    EXPECT_NEAR(box.min[axis], expect.bounds.min[axis], expect.tolerance);
    EXPECT_NEAR(box.max[axis], expect.bounds.max[axis], expect.tolerance);
  }
  for (const glm::vec3& n : cloud.normals) EXPECT_NEAR(glm::length(n), 1.0f, 1e-5f);
  if (expect.first_color) {
    EXPECT_EQ(cloud.colors.at(0), *expect.first_color);
  }
  for (const float radius : cloud.radii) {
    EXPECT_GT(radius, 0.0f);
    EXPECT_LE(static_cast<double>(radius), expect.largest_radius.value_or(radius));
  }
}

TEST(HardCases, are_read_as_their_manifest_states) {
  const TemporaryFolder folder;
  for (const HardCase& hard : hard_cases()) {
    SCOPED_TRACE(hard.file);
    const std::filesystem::path path = write(folder, hard);
    hard.expect.reads() ? expect_cloud(path, hard.expect)
                        : expect_error(path, hard.expect.error_names);
  }
}

TEST(HardCases, give_octrees_of_the_depth_that_their_manifest_states) {
  const TemporaryFolder folder;
  for (const HardCase& hard : hard_cases()) {
    SCOPED_TRACE(hard.file);
    if (!hard.expect.reads()) continue;
    const Result<LoadedCloud> loaded = read_cloud_file(write(folder, hard));
    if (!loaded) continue;  // reported by the test above
    const PointCloud& cloud = loaded->cloud;
    const auto sorted =
        sort_to_depth(cloud, bounding_cube(bounds(cloud)), DepthRule::by_delta(0.0));
    ASSERT_TRUE(sorted.has_value()) << sorted.error().message;
    const Svo svo = build_svo(sorted->sorted, sorted->depth);
    EXPECT_EQ(svo.depth, hard.expect.depth.value_or(svo.depth));
    EXPECT_EQ(svo.leaf_count(), hard.expect.leaves.value_or(svo.leaf_count()));
    EXPECT_EQ(svo.leaf_count() > 0, hard.expect.points > 0);
  }
}

struct Packed {
  int code = -1;
  std::string errors;
};

/// Packs a file or folder as a user would.
Packed pack_command(const std::filesystem::path& from, const std::filesystem::path& reel) {
  cli::Program app;
  Packed packed;
  add_pack_command(app, packed.code);
  testing::internal::CaptureStdout();
  testing::internal::CaptureStderr();
  const auto parsed = app.parse(
      {"pack", "-i", from.string(), "-o", reel.string(), "--cube", "frame", "--threads", "1"});
  EXPECT_TRUE(parsed) << parsed.error().message;
  std::fflush(stdout);
  testing::internal::GetCapturedStdout();
  packed.errors = testing::internal::GetCapturedStderr();
  return packed;
}

TEST(HardCases, are_packed_if_their_manifest_says_so) {
  // All cases go into one reel. One by one they would wait for the disk a hundred times.
  const TemporaryFolder folder, output;
  const std::filesystem::path reel = output.path() / "hard.reel";
  std::size_t count = 0;
  for (const HardCase& hard : hard_cases()) {
    if (!hard.expect.reads() || !hard.expect.packs) continue;
    write(folder, hard);
    ++count;
  }
  const Packed packed = pack_command(folder.path(), reel);
  EXPECT_EQ(packed.code, 0) << packed.errors;
  const auto manifest = read_manifest(reel);
  ASSERT_TRUE(manifest.has_value());
  EXPECT_EQ(manifest->frame_count(), count);
}

TEST(HardCases, are_otherwise_refused_in_one_line_that_names_the_file) {
  const TemporaryFolder folder;
  const std::filesystem::path reel = folder.path() / "out.reel";
  for (const HardCase& hard : hard_cases()) {
    if (hard.expect.reads() && hard.expect.packs) continue;
    SCOPED_TRACE(hard.file);
    const std::filesystem::path path = write(folder, hard);
    const Packed packed = pack_command(path, reel);
    EXPECT_EQ(packed.code, kExitFailed);
    EXPECT_EQ(std::count(packed.errors.begin(), packed.errors.end(), '\n'), 1) << packed.errors;
    EXPECT_THAT(packed.errors, HasSubstr(path.string()));
    EXPECT_FALSE(std::filesystem::exists(reel));
  }
}

TEST(HardCaseList, has_a_file_for_every_case_that_a_file_can_express) {
  std::set<std::string> rows;
  for (const HardCase& c : hard_cases()) rows.insert(c.stage + ": " + c.row);
  for (const char* row : {"ingest: NaN or infinite position",
                          "ingest: far coordinates",
                          "ingest: unusable normal",
                          "ingest: unusable radius",
                          "ingest: ascii",
                          "ingest: little endian",
                          "ingest: big endian",
                          "ingest: scalar types",
                          "ingest: double positions",
                          "ingest: 16-bit colours",
                          "ingest: float colours",
                          "ingest: no colours",
                          "ingest: list properties",
                          "ingest: faces",
                          "ingest: CRLF",
                          "ingest: comments",
                          "ingest: trailing garbage",
                          "ingest: header larger than the data",
                          "quantisation: maximum face",
                          "quantisation: no extent",
                          "octree: no points",
                          "octree: identical points",
                          "octree: level 21",
                          "octree: input order"}) {
    EXPECT_TRUE(rows.contains(row)) << row;
  }
}

TEST(HardCaseList, names_every_file_once_and_writes_the_same_bytes_again) {
  std::set<std::string> files;
  const std::vector<HardCase> cases = hard_cases(), again = hard_cases();
  for (std::size_t i = 0; i < cases.size(); ++i) {
    EXPECT_TRUE(files.insert(cases[i].file).second) << cases[i].file;
    EXPECT_TRUE(cases[i].file.ends_with(".ply"));
    EXPECT_TRUE(cases[i].bytes == again[i].bytes) << cases[i].file;
  }
}

TEST(HardCaseList, has_a_manifest_of_all_files) {
  const std::vector<HardCase> cases = hard_cases();
  const nlohmann::json manifest = nlohmann::json::parse(hard_manifest(cases));
  ASSERT_EQ(manifest.at("files").size(), cases.size());
  for (std::size_t i = 0; i < cases.size(); ++i) {
    const nlohmann::json& entry = manifest.at("files")[i];
    EXPECT_EQ(entry.at("file"), cases[i].file);
    EXPECT_EQ(entry.at("expect").at("reads"), cases[i].expect.reads());
    EXPECT_EQ(entry.at("bytes"), cases[i].bytes.size());
  }
}

}  // namespace
}  // namespace pointreel::hard_cases_test
