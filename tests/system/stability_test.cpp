#include <set>
#include <string>

#include <gtest/gtest.h>

#include "tests/stability/check.h"

namespace pointreel::stability::stability_test {
namespace {

void expect_passed(const Checks& checks) {
  EXPECT_FALSE(checks.empty());
  for (const Check& check : checks) {
    EXPECT_TRUE(check.passed) << check.stage << ", " << check.subject << ": required "
                              << check.required << "; " << check.outcome;
    EXPECT_FALSE(check.required.empty());
    EXPECT_FALSE(check.outcome.empty());
  }
}

struct Stage {
  const char* name;
  Checks (*run)();
};

class Stability : public testing::TestWithParam<Stage> {};

TEST_P(Stability, every_hard_case_has_the_required_outcome) { expect_passed(GetParam().run()); }

INSTANTIATE_TEST_SUITE_P(
    Stages, Stability,
    testing::Values(Stage{"ingest", ingest_checks}, Stage{"quantisation", quantisation_checks},
                    Stage{"octree", octree_checks}, Stage{"drawing", drawing_checks},
                    Stage{"temporal", temporal_checks}, Stage{"stream", stream_checks},
                    Stage{"coordinates", coordinate_checks}, Stage{"delta", delta_checks},
                    Stage{"depth", depth_checks}, Stage{"determinism", determinism_checks}),
    [](const auto& stage) { return stage.param.name; });

TEST(StabilityRows, are_each_checked_here_or_refer_to_another_test) {
  std::set<std::pair<std::string, std::string>> checked;
  for (const Check& check : run_stability_checks()) checked.emplace(check.stage, check.subject);
  for (const HardRow& row : hard_rows()) {
    EXPECT_NE(checked.contains({row.stage, row.subject}), !row.elsewhere.empty())
        << row.stage << ": " << row.subject;
  }
}

TEST(StabilityCheck, is_complete_when_written_as_json) {
  const nlohmann::json json = to_json({"stage", "subject", "required", "outcome", true});
  EXPECT_EQ(json.dump(), R"({"outcome":"outcome","passed":true,"required":"required",)"
                         R"("stage":"stage","subject":"subject"})");
}

}  // namespace
}  // namespace pointreel::stability::stability_test
