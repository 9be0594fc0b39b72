// The report of cleaning, made as a user makes it but with few figures: complete, plausible, and
// readable. No test here depends on speed.

#include <filesystem>
#include <map>
#include <optional>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/e2e/process.h"
#include "tests/read_file.h"
#include "tests/temporary_folder.h"

namespace pointreel::e2e::surface_report_test {
namespace {

using nlohmann::json;

class SurfaceReport : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_.emplace();
    outcome_ = run("pointreel-bench", {"surface", "--quick", "-o", folder_->path()}, 600);
    report_ = json::parse(read_file(*folder_ / "surface.json"), nullptr, false);
  }
  static void TearDownTestSuite() { folder_.reset(); }

  void SetUp() override {
    ASSERT_EQ(outcome_.exit_code, 0) << outcome_.err;
    ASSERT_TRUE(report_.is_object());
  }

  /// The rows of a group by their setting.
  static std::map<std::string, json> rows(std::size_t group) {
    std::map<std::string, json> out;
    for (const json& row : report_["groups"][group]["rows"]) out[row["setting"]] = row;
    return out;
  }

  static inline std::optional<TemporaryFolder> folder_;
  static inline Outcome outcome_;
  static inline json report_;
};

TEST_F(SurfaceReport, has_every_figure_of_every_setting) {
  ASSERT_EQ(report_["captures"].size(), 2u);
  ASSERT_EQ(report_["groups"].size(), 2u);
  for (const json& capture : report_["captures"]) {
    ASSERT_GE(capture["rows"].size(), 9u);
    for (const json& row : capture["rows"]) {
      EXPECT_GT(row["surfels"], 1000.0) << row.dump();
      EXPECT_LE(row["surfels"], row["points"]) << row.dump();
      EXPECT_NEAR(row["bits"].get<double>(),
                  row["geometry_bits"].get<double>() + row["color_bits"].get<double>() +
                      row["normal_bits"].get<double>(),
                  1e-6);
      EXPECT_GE(row["surfel_bits"], row["bits"]) << row.dump();
      EXPECT_GT(row["distance_rms_mm"], 0.0) << row.dump();
      EXPECT_GT(row["distance_p95_mm"], row["distance_rms_mm"]) << row.dump();
      EXPECT_GT(row["normal_p95_degrees"], row["normal_mean_degrees"]) << row.dump();
      EXPECT_LE(row["normal_p95_degrees"], 180.0) << row.dump();
      if (!row["depth"].is_null()) continue;  // these have no pictures
      EXPECT_GT(row["psnr"], 8.0) << row.dump();
      for (const char* share : {"ssim", "holes", "iou"}) {
        EXPECT_GE(row[share], 0.0) << row.dump();
        EXPECT_LE(row[share], 1.0) << row.dump();
      }
    }
  }
}

TEST_F(SurfaceReport, finds_cleaned_frames_smaller_and_closer_to_the_truth) {
  for (const std::size_t group : {0u, 1u}) {
    auto row = rows(group);
    for (const char* figure : {"bits", "surfels", "distance_rms_mm", "normal_mean_degrees",
                               "normal_p95_degrees", "movement_rms_mm"}) {
      EXPECT_LT(row["auto"][figure], row["off"][figure]) << figure;
    }
    for (const char* figure : {"psnr", "ssim", "iou"}) {
      EXPECT_GT(row["auto"][figure], row["off"][figure]) << figure;
    }
    EXPECT_LT(row["auto"]["normal_mean_degrees"], row["radius 10 mm"]["normal_mean_degrees"]);
  }
}

TEST_F(SurfaceReport, shows_smaller_errors_for_deeper_octrees) {
  for (const std::size_t group : {0u, 1u}) {
    auto row = rows(group);
    for (const std::string setting : {"off", "auto"}) {
      const json &coarse = row[setting + ", depth 8"], &fine = row[setting + ", depth 9"];
      EXPECT_LT(fine["distance_rms_mm"], coarse["distance_rms_mm"]) << setting;
      EXPECT_GT(fine["bits"], coarse["bits"]) << setting;
    }
  }
}

TEST_F(SurfaceReport, has_a_row_for_each_beta) {
  for (const std::size_t group : {0u, 1u})
    for (const char* setting : {"beta 0", "beta 0.25", "auto", "beta 0.75", "beta 1"})
      EXPECT_TRUE(rows(group).contains(setting)) << setting;
}

TEST_F(SurfaceReport, names_the_library_or_says_that_it_is_missing) {
  const std::string text = read_file(*folder_ / "surface.md");
  const bool has_rows = text.find("| CGAL bilateral, 2x |") != std::string::npos;
  EXPECT_EQ(has_rows, report_["library"].is_string());
  EXPECT_EQ(has_rows, text.find("built without libcgal-dev") == std::string::npos);
}

TEST_F(SurfaceReport, tells_what_the_surfaces_of_leaves_gain_and_what_the_samples_allow) {
  for (const std::size_t group : {0u, 1u}) {
    auto row = rows(group);
    EXPECT_LT(row["off, settled"]["distance_rms_mm"], row["off"]["distance_rms_mm"]);
    EXPECT_EQ(row["off, settled"]["bits"], row["off"]["bits"]);
    for (const char* figure : {"distance_rms_mm", "normal_mean_degrees"})
      EXPECT_LT(row["truth"][figure], row["auto"][figure]) << figure;
    EXPECT_GT(row["truth"]["psnr"], row["auto"]["psnr"]);
  }
}

TEST_F(SurfaceReport, measures_close_views) {
  for (const json& group : report_["groups"]) {
    const json& views = group["close_views"];
    ASSERT_EQ(views.size(), 3u);
    EXPECT_EQ(views[0]["surfels"], 0.0);
    for (const json& view : views) {
      EXPECT_GT(view["psnr"], 10.0) << view.dump();
      EXPECT_GT(view["iou"], 0.9) << view.dump();
    }
    EXPECT_GT(views[1]["surfels"], 100'000.0);
  }
  // Dense scans have more detail in their colours than large surfels show.
  const json& scans = report_["groups"][0]["close_views"];
  EXPECT_GT(scans[1]["psnr"], scans[0]["psnr"]);
}

TEST_F(SurfaceReport, contains_its_plots_and_bars) {
  const std::string text = read_file(*folder_ / "surface.md");
  EXPECT_NE(text.find("no bar is judged"), std::string::npos);
  EXPECT_EQ(report_["bars"].size(), 14u);
  for (const std::string plot : {"surface_radius.svg", "surface_beta.svg", "surface_rate.svg"}) {
    EXPECT_NE(read_file(*folder_ / plot).find("</svg>"), std::string::npos) << plot;
    EXPECT_NE(text.find("](" + plot + ")"), std::string::npos) << plot;
  }
}

}  // namespace
}  // namespace pointreel::e2e::surface_report_test
