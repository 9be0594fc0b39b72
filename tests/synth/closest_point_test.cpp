#include "datasets_synthetic/closest_point.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include "codec/distance/nearest.h"
#include "datasets_synthetic/motion.h"
#include "datasets_synthetic/random.h"
#include "datasets_synthetic/samplers/uniform.h"

namespace pointreel::closest_point_test {
namespace {

SurfaceGrid grid_of(Surface surface) {
  auto grid = SurfaceGrid::build(std::move(surface));
  EXPECT_TRUE(grid) << grid.error().message;
  return std::move(grid).value();
}

RoundCone ball(const glm::dvec3& center, double radius) { return {center, center, radius, radius}; }

/// Balls of radius 0.1 around (+-0.08, 0, 0), which meet in a circle of radius 0.06.
Surface two_balls(double blend) {
  return {{ball({-0.08, 0, 0}, 0.1), ball({0.08, 0, 0}, 0.1)},
          blend > 0.0 ? std::vector<Blend>{{0, 1, blend}}
                      : std::vector<Blend>{{0, 0, 0.0}, {1, 1, 0.0}}};
}

const Body& figure() {
  static const Body body = pose_body(find_motion("walk")->pose(0.3));
  return body;
}
const SurfaceGrid& figure_grid() {
  static const SurfaceGrid grid = grid_of(figure().surface);
  return grid;
}

TEST(TrueDistance, equals_the_distance_to_a_single_primitive) {
  const Ellipsoid egg{{0.1, 0.2, 0.3}, glm::dmat3(1.0), {0.1, 0.2, 0.15}};
  const SurfaceGrid grid = grid_of({{egg}, {{0, 0, 0.0}}});
  Random random(1, 0);
  for (int i = 0; i < 500; ++i) {
    const glm::dvec3 p(random.uniform(), random.uniform(), random.uniform());
    EXPECT_NEAR(true_distance(grid, p), std::abs(distance_to(egg, p).value), 1e-7);
  }
}

TEST(TrueDistance, reaches_a_crease_from_inside_it) {
  const SurfaceGrid grid = grid_of(two_balls(0.0));
  for (const double depth : {1e-6, 0.001, 0.004, 0.02}) {
    // The own surface of either ball is nearer, but it is buried in the other ball.
    EXPECT_NEAR(true_distance(grid, {0.0, 0.06 - depth, 0.0}), depth, 1e-7);
    EXPECT_NEAR(true_distance(grid, {0.2 * depth, 0.0, 0.06 - depth}), std::hypot(1.0, 0.2) * depth,
                1e-7);
  }
  // Outside, the distance is that to the nearer ball.
  const glm::dvec3 p(0.001, 0.063, 0.0);
  EXPECT_NEAR(true_distance(grid, p), glm::distance(p, {0.08, 0, 0}) - 0.1, 1e-7);
}

TEST(TrueDistance, reaches_the_corner_of_three_balls_from_inside_them) {
  // The balls lie at the corners of a triangle around 0. Their surfaces meet above it at height
  // 0.06.
  Surface surface;
  for (int i = 0; i < 3; ++i) {
    const double turn = 2.0 * 3.141592653589793 * i / 3.0;
    surface.primitives.push_back(ball({0.08 * std::cos(turn), 0.0, 0.08 * std::sin(turn)}, 0.1));
    surface.blends.push_back({static_cast<std::uint16_t>(i), static_cast<std::uint16_t>(i), 0.0});
  }
  const SurfaceGrid grid = grid_of(surface);
  for (const double depth : {0.0005, 0.002, 0.01}) {
    EXPECT_NEAR(true_distance(grid, {0.0, 0.06 - depth, 0.0}), depth, 1e-7);
  }
}

TEST(TrueDistance, exceeds_the_value_of_the_field_in_a_fillet) {
  constexpr double kBlend = 0.06;
  const SurfaceGrid grid = grid_of(two_balls(kBlend));
  // Halfway between the balls, the fillet is at distance blend / 4 from both.
  const double radius = std::sqrt(std::pow(0.1 + kBlend / 4.0, 2) - 0.08 * 0.08);
  for (const double off : {-0.004, -0.001, 1e-5, 0.001, 0.004}) {
    const glm::dvec3 p(0.0, 0.0, radius + off);
    EXPECT_NEAR(true_distance(grid, p), std::abs(off), 1e-7);
    EXPECT_LT(std::abs(distance_to(grid.surface(), p).distance.value), 0.8 * std::abs(off));
  }
}

TEST(TrueDistance, recovers_how_far_a_point_was_moved_along_its_normal) {
  const auto points = sample_uniform(figure().surface, 2000, 1).value();
  std::size_t nearer = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double way = (static_cast<double>(i % 9) - 4.0) * 0.0005;
    const double distance =
        true_distance(figure_grid(), points[i].position + way * points[i].normal);
    ASSERT_LE(distance, std::abs(way) + 1e-7) << i;
    // In front of a crease, another part may be nearer.
    if (distance < std::abs(way) - 1e-7) ++nearer;
  }
  EXPECT_LT(nearer, points.size() / 200);
}

TEST(TrueDistance, agrees_with_the_nearest_of_many_samples) {
  const auto samples = sample_uniform(figure().surface, 50'000, 2).value();
  std::vector<glm::dvec3> positions, queries;
  for (const SurfacePoint& sample : samples) positions.push_back(sample.position);
  Random random(3, 0);
  for (std::size_t i = 0; i < 300; ++i) {
    // Up to 6 mm inside the figure and up to 10 cm outside it.
    const double way = i % 2 == 0 ? 0.1 * random.uniform() : -0.006 * random.uniform();
    queries.push_back(samples[i].position + way * samples[i].normal);
  }
  const NearestPoints nearest = nearest_points(queries, positions, 0.0);
  constexpr double kGap = 0.02;  // no point of the surface is farther from a sample
  for (std::size_t i = 0; i < queries.size(); ++i) {
    const double distance = true_distance(figure_grid(), queries[i]);
    ASSERT_LE(distance, std::sqrt(nearest.squared_distances[i]) + 1e-7) << i;
    ASSERT_GE(distance * distance, nearest.squared_distances[i] - kGap * kGap) << i;
    ASSERT_GE(distance, std::abs(distance_to(figure().surface, queries[i]).distance.value) - 1e-7);
  }
}

TEST(TrueDistance, gives_the_same_for_a_cloud_on_any_number_of_threads) {
  PointCloud cloud;
  cloud.origin = {0.0, 1.0, 0.0};
  Random random(4, 0);
  for (int i = 0; i < 1500; ++i) {
    cloud.positions.emplace_back(0.5 * random.normal(), 0.5 * random.normal(),
                                 0.5 * random.normal());
  }
  const auto in_threads = [&](int threads) {
    tbb::task_arena arena(threads);
    return arena.execute([&] { return true_distances(figure_grid(), cloud); });
  };
  const std::vector<double> one = in_threads(1);
  EXPECT_EQ(one, in_threads(4));
  EXPECT_EQ(one[7], true_distance(figure_grid(), cloud.world(7)));
}

}  // namespace
}  // namespace pointreel::closest_point_test
