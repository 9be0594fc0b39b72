// Meshes of reels, as a user makes them, and as another program reads them.

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "codec/files/ply.h"
#include "tests/e2e/process.h"
#include "tests/temporary_folder.h"

namespace pointreel::e2e::mesh_test {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

constexpr int kFrames = 3;

/// A coloured ball far from zero, which grows.
PointCloud ball(int frame, bool normals) {
  constexpr int kPoints = 4000;
  PointCloud cloud;
  cloud.origin = {5000.0, -20.0, 0.25};
  for (int i = 0; i < kPoints; ++i) {
    const double z = 1.0 - 2.0 * (i + 0.5) / kPoints, turn = 2.399963 * i;
    const double r = std::sqrt(1.0 - z * z);
    const glm::vec3 n(r * std::cos(turn), r * std::sin(turn), z);
    cloud.positions.push_back((1.0f + 0.1f * static_cast<float>(frame)) * n);
    if (normals) cloud.normals.push_back(n);
    cloud.colors.emplace_back(257 * 200, 257 * (i % 256), 0);
  }
  return cloud;
}

class Mesh : public testing::TestWithParam<const char*> {
 protected:
  void SetUp() override {
    fs::create_directories(folder_ / "in");
    for (int i = 0; i < kFrames; ++i)
      ASSERT_TRUE(write_ply(folder_ / fmt::format("in/{}.ply", i), ball(i, i != 1)));
    const Outcome packed = run("pointreel-server", {"pack", "-i", (folder_ / "in").string(), "-o",
                                                    reel(), "--codec", GetParam()});
    ASSERT_EQ(packed.exit_code, 0) << packed.err;
  }

  std::string reel() const { return (folder_ / "reel").string(); }
  std::string out() const { return (folder_ / "out").string(); }

  Outcome unpack(std::vector<std::string> more) const {
    std::vector<std::string> arguments = {"unpack", "-i", reel(), "-o", out(), "--force"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run("pointreel-server", arguments);
  }

  TemporaryFolder folder_;
};
INSTANTIATE_TEST_SUITE_P(Codecs, Mesh, testing::Values("octree", "draco"),
                         [](const auto& codec) { return std::string(codec.param); });

/// What Debian's assimp says about a file; empty if there is no assimp.
std::string assimp_info(const fs::path& file) {
  const Outcome found = run("/bin/sh", {"-c", "command -v assimp"});
  if (found.exit_code != 0) return {};
  return run("/bin/sh", {"-c", "exec assimp info \"$0\"", file.string()}).out;
}

double number_after(const std::string& text, const std::string& label) {
  const std::size_t at = text.find(label);
  EXPECT_NE(at, std::string::npos) << label << " is not in " << text;
  return at == std::string::npos ? 0.0 : std::atof(text.c_str() + at + label.size());
}

TEST_P(Mesh, of_every_format_is_read_by_another_program) {
  for (const std::string format : {"ply", "obj", "glb"}) {
    const Outcome outcome = unpack({"--mesh", "--format", format, "--triangles", "2000"});
    ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
    EXPECT_THAT(outcome.out, HasSubstr("3 frames, "));
    EXPECT_EQ(outcome.err, "");
    for (int i = 0; i < kFrames; ++i) {
      const fs::path file = fs::path(out()) / fmt::format("frame_{:05}.{}", i, format);
      ASSERT_TRUE(fs::exists(file)) << file;
      const std::string info = assimp_info(file);
      if (info.empty())
        GTEST_SKIP() << "there is no assimp; Debian has it in the package assimp-utils";
      const double faces = number_after(info, "Faces:");
      EXPECT_LE(faces, 2000) << format;
      EXPECT_GT(faces, 1800) << format;
      EXPECT_NEAR(number_after(info, "Maximum point      ("), 5001.0 + 0.1 * i, 0.02) << format;
    }
  }
}

TEST_P(Mesh, animation_holds_all_frames_in_one_file) {
  const Outcome outcome = unpack({"--mesh", "--format", "glb", "--animation", "--frames", "1-2"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(out()))
    names.push_back(entry.path().filename().string());
  EXPECT_THAT(names, testing::ElementsAre("animation.glb"));
  const std::string info = assimp_info(fs::path(out()) / "animation.glb");
  if (info.empty()) GTEST_SKIP() << "there is no assimp; Debian has it in the package assimp-utils";
  EXPECT_THAT(info, HasSubstr("Meshes:             2"));
  EXPECT_THAT(info, HasSubstr("Animations:         1"));
}

TEST_P(Mesh, has_as_many_triangles_as_its_cells_say) {
  const auto triangles = [&](const char* cell) {
    const Outcome outcome = unpack({"--mesh", "--frames", "0", "--cell", cell});
    return number_after(outcome.out, "1 frame, ");
  };
  EXPECT_NEAR(triangles("0.1") / triangles("0.2"), 4.0, 0.8);
}

TEST_P(Mesh, options_that_do_not_go_together_are_refused) {
  EXPECT_EQ(unpack({"--format", "glb"}).exit_code, 2);
  EXPECT_EQ(unpack({"--triangles", "100"}).exit_code, 2);
  EXPECT_EQ(unpack({"--mesh", "--cell", "0"}).exit_code, 2);
  EXPECT_EQ(unpack({"--mesh", "--cell", "nan"}).exit_code, 2);
  EXPECT_EQ(unpack({"--mesh", "--triangles", "0"}).exit_code, 2);
  const Outcome animation = unpack({"--mesh", "--animation"});
  EXPECT_EQ(animation.exit_code, 2);
  EXPECT_THAT(animation.err, HasSubstr("add --format glb"));
  EXPECT_FALSE(fs::exists(out()));
}

TEST_P(Mesh, that_takes_too_much_memory_is_refused) {
  const Outcome outcome = unpack({"--mesh", "--frame-memory", "1"});
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_THAT(outcome.err, HasSubstr("--frame-memory"));
  EXPECT_FALSE(fs::exists(out()));
}

TEST(MeshOfFewPoints, is_empty_and_said) {
  const TemporaryFolder folder;
  fs::create_directories(folder / "in");
  PointCloud one;
  one.positions = {glm::vec3(1.0f)};
  ASSERT_TRUE(write_ply(folder / "in" / "0.ply", PointCloud{}));
  ASSERT_TRUE(write_ply(folder / "in" / "1.ply", one));
  const std::string reel = (folder / "reel").string(), out = (folder / "out").string();
  ASSERT_EQ(run("pointreel-server", {"pack", "-i", (folder / "in").string(), "-o", reel}).exit_code,
            0);
  for (const std::string format : {"ply", "obj", "glb"}) {
    const Outcome outcome = run("pointreel-server", {"unpack", "-i", reel, "-o", out, "--mesh",
                                                     "--format", format, "--force"});
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    EXPECT_THAT(outcome.out, HasSubstr("2 frames, 0 triangles"));
    EXPECT_THAT(outcome.err, HasSubstr("1 of 2 frames has points but no surface"));
    EXPECT_TRUE(fs::exists(fs::path(out) / ("frame_00001." + format)));
  }
}

}  // namespace
}  // namespace pointreel::e2e::mesh_test
