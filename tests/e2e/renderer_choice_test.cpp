// Pictures are drawn where there is no OpenGL, and on request by one or the other renderer.

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "codec/files/ply.h"
#include "tests/e2e/process.h"
#include "tests/paths.h"
#include "tests/temporary_folder.h"

namespace pointreel::e2e::renderer_choice_test {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

class RendererChoiceTest : public testing::Test {
 protected:
  void SetUp() override {
    PointCloud cloud;
    for (int i = 0; i < 400; ++i) {
      cloud.positions.emplace_back(0.05f * static_cast<float>(i % 20),
                                   0.05f * static_cast<float>(i / 20), 0.0f);
      cloud.normals.emplace_back(0.0f, 0.0f, 1.0f);
    }
    fs::create_directories(folder_ / "frames");
    ASSERT_TRUE(write_ply(folder_ / "frames" / "0.ply", cloud));
    // Libraries that cannot be loaded, as if none were installed.
    fs::create_directories(folder_ / "broken");
    for (const char* name : {"libEGL.so.1", "libGL.so.1", "libOpenGL.so.0", "libGLX.so.0"})
      std::ofstream(folder_ / "broken" / name);
  }

  Outcome play(const std::string& renderer, bool with_opengl,
               const std::vector<std::string>& more = {}) {
    std::vector<std::string> arguments = {"-c",           "exec \"$@\"",
                                          "sh",           program_folder() / "pointreel",
                                          "play",         (folder_ / "frames").string(),
                                          "--renderer",   renderer,
                                          "--offscreen",  "160x120",
                                          "--json",       "-",
                                          "--screenshot", (folder_ / "picture.png").string()};
    arguments.insert(arguments.end(), more.begin(), more.end());
    if (!with_opengl)
      arguments[1] = "LD_LIBRARY_PATH=" + (folder_ / "broken").string() + " exec \"$@\"";
    return run("/bin/sh", arguments);
  }

  std::string renderer_of(const Outcome& outcome) {
    const auto json = nlohmann::json::parse(outcome.out, nullptr, false);
    return json.is_discarded() ? outcome.err : json["renderer"].get<std::string>();
  }

  const TemporaryFolder folder_;
};

TEST_F(RendererChoiceTest, draws_without_any_opengl_library) {
  for (const char* renderer : {"auto", "software"}) {
    const Outcome outcome = play(renderer, false);
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    EXPECT_THAT(renderer_of(outcome), HasSubstr("software"));
    EXPECT_GT(fs::file_size(folder_ / "picture.png"), 100u);
  }
}

TEST_F(RendererChoiceTest, says_what_to_do_where_opengl_is_asked_for_and_missing) {
  const Outcome outcome = play("opengl", false);
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_THAT(outcome.err, HasSubstr("--renderer software"));
}

TEST_F(RendererChoiceTest, says_that_instancing_does_nothing_without_opengl) {
  const Outcome without = play("auto", false, {"--instancing", "texture"});
  EXPECT_EQ(without.exit_code, 0) << without.err;
  EXPECT_THAT(without.err, HasSubstr("--instancing texture is a way of OpenGL"));
  EXPECT_EQ(play("auto", false).err, "");
  EXPECT_EQ(play("opengl", true, {"--instancing", "texture"}).err, "");
}

TEST_F(RendererChoiceTest, takes_the_renderer_that_is_asked_for) {
  EXPECT_THAT(renderer_of(play("opengl", true)), HasSubstr("OpenGL"));
  EXPECT_THAT(renderer_of(play("software", true)), HasSubstr("software"));
  EXPECT_EQ(play("cuda", true).exit_code, 2);
}

}  // namespace
}  // namespace pointreel::e2e::renderer_choice_test
