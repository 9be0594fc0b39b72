// The report, made as a user makes it but with few figures: complete, readable, and consistent with
// itself. No test here depends on speed.

#include <filesystem>
#include <optional>
#include <set>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/e2e/process.h"
#include "tests/read_file.h"
#include "tests/temporary_folder.h"

namespace pointreel::e2e::report_test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

class Report : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_.emplace();
    outcome_ = run("pointreel-bench", {"report", "--quick", "-o", folder_->path()}, 600);
    report_ = json::parse(read_file(*folder_ / "report.json"), nullptr, false);
  }
  static void TearDownTestSuite() { folder_.reset(); }

  static inline std::optional<TemporaryFolder> folder_;
  static inline Outcome outcome_;
  static inline json report_;
};

TEST_F(Report, covers_every_dataset_and_codec) {
  ASSERT_EQ(outcome_.exit_code, 0) << outcome_.err;
  ASSERT_TRUE(report_.is_object());
  EXPECT_EQ(report_["structure"].size(), 5u);
  ASSERT_EQ(report_["codecs"].size(), 6u);
  for (const json& dataset : report_["codecs"]) {
    std::set<std::string> codecs;
    for (const json& row : dataset["rows"]) {
      codecs.insert(row["codec"]);
      EXPECT_GT(row["bits"]["all"], 0.0);
      EXPECT_GT(row["pack_mib"], 1.0);
      EXPECT_GT(row["truth"]["mean"], 0.0);
      EXPECT_GE(row["max_cells"], 0.0);
      EXPECT_LE(row["max_cells"], 0.9);  // half the diagonal of a cell, plus rounding
    }
    EXPECT_GE(codecs.size(), 3u);
  }
}

TEST_F(Report, shows_smaller_errors_for_more_bits) {
  ASSERT_EQ(outcome_.exit_code, 0) << outcome_.err;
  for (const json& dataset : report_["codecs"]) {
    const json* coarser = nullptr;
    for (const json& row : dataset["rows"]) {
      if (coarser != nullptr && (*coarser)["codec"] == row["codec"]) {
        EXPECT_GT(row["bits"]["geometry"], (*coarser)["bits"]["geometry"]);
        EXPECT_LT(row["d1_rms"], (*coarser)["d1_rms"]);
      }
      coarser = &row;
    }
  }
}

TEST_F(Report, contains_all_stability_checks) {
  ASSERT_EQ(outcome_.exit_code, 0) << outcome_.err;
  EXPECT_GT(report_["stability"].size(), 30u);
  for (const json& check : report_["stability"]) {
    EXPECT_TRUE(check["passed"]) << check.dump();
  }
}

TEST_F(Report, contains_its_plots_and_chapters) {
  ASSERT_EQ(outcome_.exit_code, 0) << outcome_.err;
  const std::string text = read_file(*folder_ / "report.md");
  for (const char* chapter :
       {"Table I", "Table III", "Codecs", "Numerical stability", "no bar is judged"}) {
    EXPECT_NE(text.find(chapter), std::string::npos) << chapter;
  }
  int plots = 0;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder_->path())) {
    if (entry.path().extension() != ".svg") continue;
    ++plots;
    const std::string svg = read_file(entry.path());
    EXPECT_NE(svg.find("prefers-color-scheme: dark"), std::string::npos) << entry.path();
    EXPECT_NE(svg.find("</svg>"), std::string::npos) << entry.path();
    EXPECT_NE(text.find("](" + entry.path().filename().string() + ")"), std::string::npos);
  }
  EXPECT_EQ(plots, 5);
  EXPECT_NE(outcome_.out.find("Written: " + (*folder_ / "report.md").string()), std::string::npos)
      << outcome_.out;
}

}  // namespace
}  // namespace pointreel::e2e::report_test
