// pointreel-bench truth, run as a user runs it: the drawn figure must be similar to the truth.

#include <cmath>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/e2e/picture.h"
#include "tests/e2e/process.h"
#include "tests/temporary_folder.h"

namespace pointreel::e2e::truth_test {
namespace {

using testing::HasSubstr;

TEST(Truth, is_rendered_from_the_view_of_the_player) {
  const TemporaryFolder folder;
  const auto path = [&](const std::string& name) { return (folder / name).string(); };
  folder.write("path.json", R"({"pointreel_camera_path": 1, "keys": [
    {"seconds": 0, "target": [0, 0.9, 0], "distance": 3, "yaw": 10, "fov": 40},
    {"seconds": 0.033333, "target": [0, 0.9, 0], "distance": 3, "yaw": 70, "fov": 40}]})");
  const Outcome cast =
      run("pointreel-bench", {"truth", "walk", "--frames", "2", "--width", "90", "--height", "120",
                              "--camera", path("path.json"), "--record", path("truth-%d.png")});
  ASSERT_EQ(cast.exit_code, 0) << cast.err;
  const Outcome scanned = run("pointreel-synth", {"walk", "--frames", "2", "--sampler", "uniform",
                                                  "--points", "20000", "-o", path("walk")});
  ASSERT_EQ(scanned.exit_code, 0) << scanned.err;
  const Outcome played =
      run("pointreel", {"play", path("walk"), "--offscreen", "90x120", "--camera",
                        path("path.json"), "--record", path("played-%d.png")});
  ASSERT_EQ(played.exit_code, 0) << played.err;
  for (const char* number : {"0", "1"}) {
    const Picture truth = read_picture(path(std::string("truth-") + number + ".png"));
    const Picture picture = read_picture(path(std::string("played-") + number + ".png"));
    ASSERT_EQ(truth.size, glm::ivec2(90, 120));
    ASSERT_EQ(picture.size, truth.size);
    const glm::ivec3 background(truth.at(0, 0));
    int figure = 0, differs = 0;
    for (std::size_t i = 0; i < truth.pixels.size(); ++i) {
      const auto far = [](const glm::ivec3& d) {
        return std::abs(d.x) + std::abs(d.y) + std::abs(d.z) > 60;
      };
      figure += far(glm::ivec3(truth.pixels[i]) - background);
      differs += far(glm::ivec3(truth.pixels[i]) - glm::ivec3(picture.pixels[i]));
    }
    EXPECT_GT(figure, 800) << number;
    EXPECT_LT(differs, figure / 3) << number;
  }
}

TEST(Truth, reports_an_unknown_sequence_in_one_line) {
  const TemporaryFolder folder;
  const Outcome cast =
      run("pointreel-bench", {"truth", "dance", "--camera", "x", "--record", "y.mp4"});
  EXPECT_EQ(cast.exit_code, 1);
  EXPECT_THAT(cast.err, HasSubstr("dance: no such sequence"));
}

}  // namespace
}  // namespace pointreel::e2e::truth_test
