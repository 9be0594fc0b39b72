#include "client/record/frame_plan.h"

#include <vector>

#include <gtest/gtest.h>

namespace pointreel::frame_plan_test {
namespace {

const Timeline kThirds{{0, 333'333, 666'667}, 1'000'000};
const Timeline kUneven{{0, 100'000, 700'000}, 900'000};

std::vector<std::uint32_t> frames(const FramePlan& plan) {
  std::vector<std::uint32_t> all;
  for (std::uint64_t i = 0; i < plan.count().value_or(0); ++i) all.push_back(plan.picture(i).frame);
  return all;
}

TEST(FramePlan, has_every_frame_once_in_order) {
  const FramePlan plan(kUneven, 0, std::nullopt, false);
  EXPECT_EQ(frames(plan), (std::vector<std::uint32_t>{0, 1, 2}));
  EXPECT_EQ(plan.picture(2).time_us, 700'000u);
  EXPECT_FALSE(plan.rate());
}

TEST(FramePlan, begins_at_the_frame_that_is_visible_at_the_start_time) {
  const FramePlan plan(kUneven, 699'999, std::nullopt, false);
  EXPECT_EQ(frames(plan), (std::vector<std::uint32_t>{1, 2}));
  EXPECT_EQ(plan.picture(0).time_us, 0u);
  EXPECT_EQ(plan.picture(0).reel_time_us, 100'000u);
  EXPECT_EQ(plan.picture(1).time_us, 600'000u);
}

TEST(FramePlan, leaves_out_frames_that_end_when_they_begin) {
  const Timeline joined{{0, 0, 0, 100'000, 200'000, 200'000, 300'000}, 400'000};
  const FramePlan plan(joined, 0, std::nullopt, false);
  EXPECT_EQ(frames(plan), (std::vector<std::uint32_t>{2, 3, 5, 6}));
  EXPECT_EQ(plan.rate(), (FrameRate{10, 1}));
  EXPECT_EQ(frames(FramePlan(joined, 250'000, std::nullopt, false)),
            (std::vector<std::uint32_t>{5, 6}));
}

TEST(FramePlan, ends_after_its_duration_even_across_several_passes) {
  EXPECT_EQ(frames(FramePlan(kUneven, 0, 700'000, false)), (std::vector<std::uint32_t>{0, 1}));
  EXPECT_EQ(frames(FramePlan(kUneven, 0, 700'001, false)), (std::vector<std::uint32_t>{0, 1, 2}));
  EXPECT_EQ(frames(FramePlan(kUneven, 0, 5'000'000, false)), (std::vector<std::uint32_t>{0, 1, 2}));
  EXPECT_EQ(frames(FramePlan(kUneven, 100'000, 1'700'001, true)),
            (std::vector<std::uint32_t>{1, 2, 0, 1, 2, 0}));
  EXPECT_TRUE(frames(FramePlan(kUneven, 0, 0, true)).empty());
}

TEST(FramePlan, leaves_no_gap_between_passes) {
  const FramePlan plan(kUneven, 100'000, std::nullopt, true);
  EXPECT_FALSE(plan.count());
  EXPECT_EQ(plan.picture(2).frame, 0u);
  EXPECT_EQ(plan.picture(2).time_us, 800'000u);
  EXPECT_EQ(plan.picture(2).reel_time_us, 900'000u);
  EXPECT_EQ(plan.picture(3 * 1'000'000).time_us, std::uint64_t{900'000} * 1'000'000);
}

TEST(FramePlan, has_a_constant_rate_across_passes_only_if_the_last_frame_keeps_it) {
  EXPECT_EQ(FramePlan(kThirds, 0, std::nullopt, false).rate(), (FrameRate{3, 1}));
  EXPECT_EQ(FramePlan(kThirds, 0, std::nullopt, true).rate(), (FrameRate{3, 1}));
  const Timeline longer{kThirds.times_us, 1'500'000};
  EXPECT_EQ(FramePlan(longer, 0, std::nullopt, false).rate(), (FrameRate{3, 1}));
  EXPECT_FALSE(FramePlan(longer, 0, std::nullopt, true).rate());
  EXPECT_EQ(FramePlan(Timeline{{0}, 40'000}, 0, std::nullopt, false).rate(), (FrameRate{25, 1}));
}

}  // namespace
}  // namespace pointreel::frame_plan_test
