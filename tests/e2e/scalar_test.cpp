// Scalar fields from files to pictures, as a user sees them.

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "codec/files/ply.h"
#include "tests/e2e/picture.h"
#include "tests/e2e/process.h"
#include "tests/temporary_folder.h"

namespace pointreel::e2e::scalar_test {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

/// A square that faces the viewer: its left half cold and of class 2, its right half warm and of
/// class 6.
PointCloud square() {
  constexpr int kSide = 64;
  PointCloud cloud;
  cloud.scalars = {{"heat", {}}, {"class", {}}};
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) {
      cloud.positions.emplace_back(static_cast<float>(x), static_cast<float>(y), 0.0f);
      cloud.normals.emplace_back(0.0f, 0.0f, 1.0f);
      cloud.scalars[0].values.push_back(x < kSide / 2 ? -10.5f : 30.25f);
      cloud.scalars[1].values.push_back(x < kSide / 2 ? 2.0f : 6.0f);
    }
  }
  return cloud;
}

class Scalars : public testing::Test {
 protected:
  void SetUp() override {
    fs::create_directories(folder_ / "in");
    ASSERT_TRUE(write_ply(folder_ / "in/0.ply", square()));
    const Outcome packed =
        run("pointreel-server", {"pack", "-i", (folder_ / "in").string(), "-o", reel()});
    ASSERT_EQ(packed.exit_code, 0) << packed.err;
    EXPECT_THAT(packed.out, HasSubstr("scalar fields"));
  }

  std::string reel() const { return (folder_ / "reel").string(); }

  /// The colours in the middle of the left and of the right half.
  struct Halves {
    glm::ivec3 left{0}, right{0};
    Picture picture;
  };
  Halves drawn(const std::string& source, std::vector<std::string> more) const {
    const std::string file = (folder_ / "picture.png").string();
    std::vector<std::string> arguments = {
        "play",   source, "--offscreen",   "200x200",      "--at", "0",
        "--view", "0,0",  "--no-lighting", "--screenshot", file};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const Outcome outcome = run("pointreel", arguments);
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    Halves halves;
    halves.picture = read_picture(file);
    if (halves.picture.size != glm::ivec2(200)) return halves;
    halves.left = halves.picture.at(80, 90);
    halves.right = halves.picture.at(120, 90);
    return halves;
  }

  const TemporaryFolder folder_;
};

bool near(const glm::ivec3& a, const glm::ivec3& b) {
  return glm::length(glm::vec3(a - b)) < 12.0f;
}

constexpr glm::ivec3 kViolet{0x37, 0x00, 0x5b}, kYellow{0xf7, 0xed, 0x6c}, kGrey{128, 128, 128};

TEST_F(Scalars, are_listed_with_their_ranges) {
  EXPECT_THAT(
      run("pointreel-server", {"info", reel()}).out,
      testing::AllOf(HasSubstr("heat, -10.5 to 30.25"), HasSubstr("class, 2 to 6, labels")));
  EXPECT_THAT(run("pointreel-server", {"verify", reel()}).out, HasSubstr(": OK, "));
}

TEST_F(Scalars, are_shown_by_their_values_by_every_renderer_and_in_every_mode) {
  for (const char* renderer : {"software", "opengl"}) {
    for (const char* mode : {"surfel", "voxel", "point", "strip"}) {
      const Halves heat =
          drawn(reel(), {"--renderer", renderer, "--mode", mode, "--color", "heat"});
      EXPECT_TRUE(near(heat.left, kViolet)) << renderer << " " << mode;
      EXPECT_TRUE(near(heat.right, kYellow)) << renderer << " " << mode;
    }
  }
}

TEST_F(Scalars, have_a_legend_in_pictures) {
  const Picture with = drawn(reel(), {"--color", "heat"}).picture;
  const Picture without = drawn(reel(), {}).picture;
  ASSERT_EQ(with.size, without.size);
  std::size_t different = 0;
  for (int y = 150; y < 192; ++y)
    for (int x = 8; x < 140; ++x) different += with.at(x, y) != without.at(x, y) ? 1u : 0u;
  EXPECT_GT(different, 3000u);
}

TEST_F(Scalars, of_files_and_in_another_range_are_shown_too) {
  const Halves files = drawn((folder_ / "in").string(), {"--color", "heat"});
  EXPECT_TRUE(near(files.left, kViolet));
  EXPECT_TRUE(near(files.right, kYellow));
  const Halves wide = drawn(reel(), {"--color", "heat", "--color-range", "-10.5,1e6"});
  EXPECT_TRUE(near(wide.right, kViolet));
  const Halves labels = drawn(reel(), {"--color", "class"});
  EXPECT_FALSE(near(labels.left, labels.right));
  EXPECT_FALSE(near(labels.left, kViolet));
}

TEST_F(Scalars, are_grey_where_their_layer_is_not_decoded) {
  const Halves base = drawn(reel(), {"--color", "heat", "--layers", "1"});
  EXPECT_TRUE(near(base.left, kGrey));
  EXPECT_TRUE(near(base.right, kGrey));
}

TEST_F(Scalars, that_are_not_there_are_an_error_that_names_the_others) {
  const Outcome outcome =
      run("pointreel", {"play", reel(), "--offscreen", "64x64", "--at", "0", "--color", "head"});
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_THAT(outcome.err, HasSubstr("there are heat, class"));
}

TEST_F(Scalars, warns_of_steps_that_are_of_no_use) {
  const Outcome packed =
      run("pointreel-server", {"pack", (folder_ / "in").string(), reel(), "--force",
                               "--scalar-step", "Heat=1", "--scalar-step", "class=0.00001"});
  EXPECT_EQ(packed.exit_code, 0);
  EXPECT_THAT(packed.err, HasSubstr("--scalar-step Heat: no frame has such a scalar field; there "
                                    "are heat, class"));
  EXPECT_THAT(packed.err, HasSubstr("0.ply: --scalar-step class=1e-05: its values from 2 to 6 are "
                                    "kept in steps of 0.00012207"));
}

TEST_F(Scalars, that_las_files_do_not_keep_are_named_in_one_line) {
  const Outcome unpacked = run("pointreel-server", {"unpack", "-i", reel(), "-o",
                                                    (folder_ / "las").string(), "--format", "las"});
  EXPECT_EQ(unpacked.exit_code, 0);
  EXPECT_THAT(unpacked.err, HasSubstr("values of class dropped"));
  EXPECT_THAT(unpacked.err, HasSubstr("values of heat dropped"));
  EXPECT_THAT(unpacked.err, HasSubstr("--up y"));
  EXPECT_EQ(std::count(unpacked.err.begin(), unpacked.err.end(), '\n'), 2);
}

}  // namespace
}  // namespace pointreel::e2e::scalar_test
