#include "codec/rate/rate_control.h"

#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "pointreel/draco.h"
#include "pointreel/octree.h"

namespace pointreel::rate_control_test {
namespace {

/// A scene whose sizes are known. The size of geometry depends on the levels, that of attributes
/// also on the quality.
struct Scene {
  int depth = 10;
  double geometry = 1e6, attributes = 1e6;
  double per_level = 4.0, headers = 100.0;

  double bytes(const Coarsening& by) const {
    const double voxels = std::pow(per_level, -by.levels);
    return headers + voxels * (geometry + attributes * std::pow(2.0, -by.quality / 14.0));
  }
};

void run(RateControl& control, const Scene& scene) {
  for (int i = 0; control.next(); ++i) {
    ASSERT_LT(i, 30) << "the search does not end";
    control.told(scene.bytes(*control.next()), scene.depth);
  }
}

/// The best choice by exhaustive search: the fewest levels, then the highest quality.
Coarsening best(const Scene& scene, double budget) {
  if (scene.bytes({0, 0}) <= budget) return {0, 0};
  for (int levels = 0; levels < scene.depth; ++levels) {
    for (int quality = 0; quality <= most_quality_lost(levels); ++quality) {
      if (scene.bytes({levels, quality}) <= budget) return {levels, quality};
    }
  }
  return {scene.depth - 1, most_quality_lost(scene.depth - 1)};
}

TEST(RateControl, changes_nothing_if_the_rate_is_sufficient) {
  RateControl control(3e6, true);
  run(control, {});
  EXPECT_TRUE(control.within_budget());
  EXPECT_EQ(control.choice(), Coarsening{});
  EXPECT_EQ(control.trials(), 1);
}

TEST(RateControl, finds_the_finest_choice_within_the_budget_in_few_trials) {
  for (const double per_level : {2.5, 4.0, 5.0}) {
    Scene scene;
    scene.per_level = per_level;
    for (double budget = 1.9e6; budget > 1000.0; budget *= 0.83) {
      RateControl control(budget, true);
      run(control, scene);
      const Coarsening wanted = best(scene, budget);
      EXPECT_TRUE(control.within_budget()) << budget;
      EXPECT_LE(scene.bytes(control.choice()), budget);
      EXPECT_EQ(control.choice().levels, wanted.levels) << budget;
      // Another choice is accepted if it uses almost the whole budget.
      if (control.choice() != wanted) {
        EXPECT_GE(scene.bytes(control.choice()), 0.95 * budget);
      }
      EXPECT_LE(control.trials(), 12) << budget;
    }
  }
}

TEST(RateControl, lowers_attributes_by_no_more_than_the_depth_justifies) {
  Scene scene;
  scene.attributes = 5e7;
  for (double budget = 2e7; budget > 1e3; budget /= 3.0) {
    RateControl control(budget, true);
    run(control, scene);
    EXPECT_LE(control.choice().quality, most_quality_lost(control.choice().levels));
  }
}

TEST(RateControl, does_not_change_the_quality_of_absent_attributes) {
  Scene scene;
  scene.attributes = 0.0;
  for (double budget = 9e5; budget > 1e3; budget /= 3.0) {
    RateControl control(budget, false);
    run(control, scene);
    EXPECT_EQ(control.choice(), (Coarsening{best(scene, budget).levels, 0}));
    EXPECT_LE(control.trials(), 5);
  }
}

TEST(RateControl, reports_that_even_the_coarsest_choice_exceeds_the_budget) {
  for (const bool attributes : {false, true}) {
    RateControl control(50.0, attributes);
    run(control, {});
    EXPECT_FALSE(control.within_budget());
    EXPECT_EQ(control.choice().levels, 9);
    EXPECT_FALSE(control.overshot(1e3));
  }
}

TEST(RateControl, cannot_coarsen_a_single_cell) {
  Scene scene;
  scene.depth = 0;
  RateControl control(150.0, false);
  run(control, scene);
  EXPECT_FALSE(control.within_budget());
  EXPECT_EQ(control.choice(), Coarsening{});
}

TEST(RateControl, coarsens_further_if_the_trials_were_too_optimistic) {
  // All frames together need a quarter more than the frames of the trials suggested.
  const Scene scene;
  for (double budget = 2.2e6; budget > 1e3; budget *= 0.77) {
    RateControl control(budget, true);
    run(control, scene);
    for (int i = 0; control.within_budget() && 1.25 * scene.bytes(control.choice()) > budget; ++i) {
      ASSERT_LT(i, 4);
      const Coarsening before = control.choice();
      ASSERT_TRUE(control.overshot(1.25 * scene.bytes(before)));
      run(control, scene);
      EXPECT_LT(scene.bytes(control.choice()), scene.bytes(before));
    }
    EXPECT_EQ(control.choice().levels, best(scene, budget / 1.25).levels) << budget;
  }
}

TEST(Coarsening, lowers_depth_and_qualities_of_the_octree_and_never_raises_them) {
  OctreeOptions asked;
  asked.depth = DepthRule::by_delta(0.05);
  asked.color_quality = 60;
  asked.normal_quality = 20;
  const auto octree = [&](const Coarsening& by) {
    return std::get<OctreeOptions>(coarsened({asked}, 11, by).codec);
  };
  EXPECT_EQ(octree({0, 0}).depth.most, kMaxDepth);
  EXPECT_EQ(octree({2, 0}).depth.most, 9);
  EXPECT_EQ(octree({2, 0}).depth.delta, 0.05);
  EXPECT_EQ(octree({30, 0}).depth.most, kCoarsestDepth);
  EXPECT_EQ(octree({1, 15}).color_quality, 45);
  EXPECT_EQ(octree({1, 15}).normal_quality, 5);
  EXPECT_EQ(octree({1, 99}).color_quality, 1);
  EXPECT_EQ(octree({1, 99}).normal_quality, 1);
  const auto bounded = no_deeper_than(coarsened({asked}, 11, {3, 0}), 9);
  EXPECT_EQ(std::get<OctreeOptions>(bounded.codec).depth.most, 8);
}

TEST(Coarsening, lowers_bits_of_positions_and_normals_of_draco) {
  const auto draco = [](const Coarsening& by) {
    return std::get<DracoOptions>(coarsened({DracoOptions{}}, 11, by).codec);
  };
  EXPECT_EQ(draco({3, 0}).position_bits, 8);
  EXPECT_EQ(draco({3, 28}).normal_bits, 6);
  EXPECT_EQ(draco({30, 200}).position_bits, kCoarsestDepth);
  EXPECT_EQ(draco({30, 200}).normal_bits, 2);
}

}  // namespace
}  // namespace pointreel::rate_control_test
