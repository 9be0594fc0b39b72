// Pictures and drawing times, measured as a user measures them but on a small scene: complete,
// readable, and consistent with what is known of every setting. No test here depends on speed.

#include <filesystem>
#include <map>
#include <optional>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/e2e/process.h"
#include "tests/read_file.h"
#include "tests/temporary_folder.h"

namespace pointreel::e2e::render_report_test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

class RenderReport : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_.emplace();
    outcome_ = run("pointreel-bench", {"render", "--quick", "-o", folder_->path()}, 600);
    report_ = json::parse(read_file(*folder_ / "report.json"), nullptr, false);
  }
  static void TearDownTestSuite() { folder_.reset(); }

  void SetUp() override {
    ASSERT_EQ(outcome_.exit_code, 0) << outcome_.err;
    ASSERT_TRUE(report_.is_object());
  }

  static inline std::optional<TemporaryFolder> folder_;
  static inline Outcome outcome_;
  static inline json report_;
};

TEST_F(RenderReport, has_every_figure_and_a_picture_for_every_setting) {
  ASSERT_EQ(report_["scenes"].size(), 2u);
  std::size_t pictures = 0;
  for (const json& scene : report_["scenes"]) {
    ASSERT_EQ(scene["views"].size(), 2u);
    for (const json& view : scene["views"]) {
      EXPECT_GT(view["coverage"], 0.25);
      EXPECT_LT(view["coverage"], 0.85);
      ASSERT_GE(view["rows"].size(), 9u);
      for (const json& row : view["rows"]) {
        for (const char* share : {"holes", "iou", "ssim", "ssim_mask"}) {
          EXPECT_GE(row[share], 0.0) << row.dump();
          EXPECT_LE(row[share], 1.0) << row.dump();
        }
        EXPECT_GT(row["psnr"], 10.0) << row.dump();
        EXPECT_GE(row["dilation"], 0.0) << row.dump();
        EXPECT_EQ(row.value("flicker", 0), 0) << row.dump();
        if (!row.contains("picture")) continue;
        EXPECT_GT(fs::file_size(*folder_ / row["picture"].get<std::string>()), 10'000u);
        ++pictures;
      }
    }
  }
  EXPECT_EQ(pictures, 2 * (report_["scenes"][0]["views"][0]["rows"].size() + 1));
}

TEST_F(RenderReport, finds_the_default_close_to_the_truth_in_any_order_of_the_splats) {
  const json& dense = report_["scenes"][1];
  ASSERT_TRUE(dense["dense"]);
  for (const json& view : dense["views"]) {
    const json& row = view["rows"][0];
    EXPECT_EQ(row["setting"], "default");
    EXPECT_GT(row["psnr_mask"], 23.0);
    EXPECT_LT(row["holes"], 0.01);
    EXPECT_GT(row["iou"], 0.97);
    EXPECT_LT(row.value("bleed", 0.0), 0.05);
  }
  for (const json& row : dense["views"][0]["rows"]) {
    if (row["setting"] == "default, holes left") {
      EXPECT_LE(row["order"]["largest"], 1);
    }
  }
}

TEST_F(RenderReport, reproduces_the_known_flaws_of_the_modes_in_figure_3) {
  std::map<std::string, json> rows;
  for (const json& row : report_["scenes"][1]["views"][0]["rows"]) rows[row["setting"]] = row;
  EXPECT_GT(rows["regular"]["order"]["rms"], 3.0);
  EXPECT_GT(rows["regular"]["holes"], rows["enlarged"]["holes"]);
  EXPECT_GT(rows["enlarged-shading"]["psnr_mask"], rows["two-pass"]["psnr_mask"]);
  EXPECT_GT(rows["enlarged-shading"]["bleed"], rows["default"]["bleed"]);
  EXPECT_GT(rows["points of a fixed size"]["holes"], rows["two-pass"]["holes"]);
  EXPECT_LT(rows["points"]["holes"], rows["two-pass"]["holes"]);
}

TEST_F(RenderReport, times_every_method_and_finds_that_their_pictures_agree) {
  const json& tables = report_["scenes"][0]["tables"];
  for (const char* what : {"surfels", "voxels"}) {
    const json& times = tables[what];
    ASSERT_EQ(times["methods"].size(), 5u);
    for (const json& method : times["methods"]) EXPECT_GT(method["ms"]["median"], 0.0);
    EXPECT_EQ(times["paper"].size(), what == std::string("voxels") ? 5u : 4u);
    // Rounding may decide differently for a pixel at an edge, which affects hardly any pixels.
    for (const json& method : times["methods"]) {
      EXPECT_NEAR(method["psnr_mask"], times["methods"]["attribute"]["psnr_mask"].get<double>(),
                  0.01);
    }
  }
  EXPECT_GT(tables["traverse_ms"]["median"], 0.0);
}

TEST_F(RenderReport, plays_every_mode) {
  ASSERT_EQ(report_["playback"].size(), 3u);
  for (const json& row : report_["playback"]) {
    EXPECT_EQ(row["frames"], 4) << row.dump();
    EXPECT_GT(row["fps"], 0.0) << row.dump();
    EXPECT_GT(row["render_ms"], 0.0) << row.dump();
  }
}

TEST_F(RenderReport, names_the_machine_and_has_bars_which_a_quick_run_does_not_judge) {
  EXPECT_NE(report_["machine"]["gl_renderer"].get<std::string>().find("OpenGL"), std::string::npos);
  ASSERT_FALSE(report_["bars"].empty());
  for (const json& bar : report_["bars"]) {
    EXPECT_TRUE(bar["value"].is_number()) << bar.dump();
    EXPECT_FALSE(bar.contains("holds")) << bar.dump();
  }
  const std::string text = read_file(*folder_ / "report.md");
  for (const char* part :
       {"soccer-shoot", "kick, dense", "Table II", "Table IV", "no bar is judged"}) {
    EXPECT_NE(text.find(part), std::string::npos) << part;
  }
}

TEST_F(RenderReport, fails_if_a_graphics_card_is_required_and_missing) {
  if (report_["stopwatch"] == "gpu") GTEST_SKIP() << "there is a GPU";
  const Outcome outcome =
      run("pointreel-bench", {"render", "--quick", "--gpu", "-o", folder_->path()});
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_NE(outcome.err.find("--gpu"), std::string::npos) << outcome.err;
}

TEST(RenderCommand, refuses_an_unknown_scene) {
  const TemporaryFolder folder;
  const Outcome outcome =
      run("pointreel-bench", {"render", "--scene", "juggling", "-o", folder.path()});
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_NE(outcome.err.find("there is no scene \"juggling\""), std::string::npos) << outcome.err;
}

}  // namespace
}  // namespace pointreel::e2e::render_report_test
