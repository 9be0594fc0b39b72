#include "codec/rate/frame_time_control.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

#include <gtest/gtest.h>

namespace pointreel::frame_time_control_test {
namespace {

constexpr double kBudget = 33.0;

/// A machine that takes `ms_at_10` for a frame of depth 10 and `growth` times as much per level.
struct Machine {
  double ms_at_10 = 10.0, growth = 3.0;
  double operator()(int depth) const { return ms_at_10 * std::pow(growth, depth - 10); }
};

/// Encodes frames with a clock that only the machine advances, and returns their depths.
std::vector<int> run(FrameTimeControl& control, const Machine& machine, int frames,
                     int asked = 10) {
  std::vector<int> depths;
  for (int i = 0; i < frames; ++i) {
    depths.push_back(std::min(asked, control.depth()));
    control.told(depths.back(), machine(depths.back()));
  }
  return depths;
}

int changes(const std::vector<int>& depths) {
  int count = 0;
  for (std::size_t i = 1; i < depths.size(); ++i) count += depths[i] != depths[i - 1] ? 1 : 0;
  return count;
}

TEST(FrameTimeControl, keeps_the_depth_of_frames_that_are_on_time) {
  FrameTimeControl control(kBudget, 10);
  const auto depths = run(control, {30.0}, 1000);
  EXPECT_EQ(depths, std::vector<int>(1000, 10));
  EXPECT_EQ(control.late(), 0u);
}

TEST(FrameTimeControl, lowers_the_depth_before_two_frames_are_late) {
  for (const double slow : {34.0, 40.0, 60.0, 90.0, 250.0}) {
    FrameTimeControl control(kBudget, 10);
    const Machine machine{slow};
    double most_behind = 0.0;
    for (int i = 0; i < 2000; ++i) {
      const int depth = control.depth();
      control.told(depth, machine(depth));
      most_behind = std::max(most_behind, control.behind_ms());
    }
    EXPECT_LE(most_behind, std::max(slow - kBudget, kBudget)) << slow;
    EXPECT_LT(control.late(), 200u) << slow;
  }
}

TEST(FrameTimeControl, forgives_a_single_late_frame) {
  FrameTimeControl control(kBudget, 10);
  run(control, {20.0}, 20);
  control.told(10, 1.4 * kBudget);
  EXPECT_EQ(control.depth(), 10);
  run(control, {20.0}, 20);
  EXPECT_EQ(control.depth(), 10);
  EXPECT_EQ(control.late(), 1u);
}

TEST(FrameTimeControl, forgives_single_stalls_of_the_machine_but_not_what_stays_slow) {
  FrameTimeControl control(kBudget, 10);
  for (int stall = 0; stall < 20; ++stall) {
    run(control, {5.0}, 50);
    control.told(10, 9.0 * kBudget);
    EXPECT_EQ(control.depth(), 10);
  }
  run(control, {5.0}, 50);
  control.told(10, 3.0 * kBudget);
  control.told(10, 3.0 * kBudget);
  EXPECT_EQ(control.depth(), 8);
  control.told(8, 1.7 * kBudget);
  EXPECT_EQ(control.depth(), 7) << "this depth has never been in time";
}

TEST(FrameTimeControl, returns_to_the_finest_depth_once_the_machine_is_fast_again) {
  FrameTimeControl control(kBudget, 10);
  run(control, {200.0}, 100);
  EXPECT_LT(control.depth(), 9);
  run(control, {10.0}, 200);
  EXPECT_EQ(control.depth(), 10);
}

TEST(FrameTimeControl, returns_soon_on_a_machine_that_others_use_again_and_again) {
  FrameTimeControl control(kBudget, 10);
  int fine = 0;
  for (int i = 0; i < 3000; ++i) {
    const int depth = control.depth();
    fine += depth == 10 ? 1 : 0;
    // Of 60 frames, one is late, and then two in a row.
    const bool late = i % 60 == 20 || i % 60 >= 58;
    control.told(depth, late ? 3.0 * kBudget : Machine{5.0, 2.0}(depth));
  }
  EXPECT_GT(fine, 900);
  EXPECT_LT(control.late(), 250u);
}

TEST(FrameTimeControl, does_not_oscillate_between_two_depths) {
  // Depth 9 is so fast that depth 10 seems possible, but it is not.
  for (const double growth : {3.0, 4.0, 8.0}) {
    FrameTimeControl control(kBudget, 10);
    const auto depths = run(control, {1.2 * kBudget, growth}, 3000);
    EXPECT_LT(changes(depths), 24) << growth;
    EXPECT_LT(control.late(), 40u) << growth;
    EXPECT_EQ(depths.back(), 9) << growth;
  }
}

TEST(FrameTimeControl, copes_with_a_machine_that_is_too_slow_for_any_depth) {
  FrameTimeControl control(kBudget, 10);
  run(control, {1e9, 2.0}, 50);
  EXPECT_EQ(control.depth(), 1);
}

TEST(FrameTimeControl, lowers_the_actual_depth_of_a_frame_instead_of_the_permitted_one) {
  FrameTimeControl control(kBudget);
  run(control, {100.0}, 2, 10);
  EXPECT_LT(control.depth(), 10);
}

TEST(FrameTimeControl, ignores_late_frames_that_began_before_the_last_change) {
  FrameTimeControl control(kBudget, 10);
  control.told(10, 3.0 * kBudget);
  const int depth = control.depth();
  EXPECT_LT(depth, 10);
  for (int i = 0; i < 4; ++i) control.told(10, 3.0 * kBudget);
  EXPECT_EQ(control.depth(), depth);
  EXPECT_EQ(control.late(), 5u);
}

TEST(FrameTimeControl, copies_behave_like_the_original) {
  FrameTimeControl control(kBudget, 10);
  run(control, {100.0}, 3);
  FrameTimeControl copy = control;
  EXPECT_EQ(run(copy, {12.0}, 300), run(control, {12.0}, 300));
}

TEST(FrameTimeControl, never_goes_below_the_least_depth_and_recovers_from_it) {
  FrameTimeControl control(10.0, 10, 6);
  for (int i = 0; i < 50; ++i) control.told(control.depth(), 400.0);
  EXPECT_EQ(control.depth(), 6);
  for (int i = 0; i < 5000; ++i) control.told(control.depth(), 1.0);
  EXPECT_EQ(control.depth(), 10);
}

}  // namespace
}  // namespace pointreel::frame_time_control_test
