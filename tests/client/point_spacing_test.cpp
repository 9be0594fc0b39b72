#include "client/prepare/point_spacing.h"

#include <cmath>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "codec/core/build.h"

namespace pointreel::point_spacing_test {
namespace {

/// Random points on a sphere of radius 1, and the number of cells that they occupy.
std::vector<std::uint32_t> occupied_by(int points, double edge) {
  std::mt19937 random(3);
  std::normal_distribution<float> normal;
  PointCloud cloud;
  for (int i = 0; i < points; ++i) {
    const glm::vec3 p(normal(random), normal(random), normal(random));
    cloud.positions.push_back(p / glm::length(p));
  }
  return sort_points(cloud, {glm::dvec3(-0.5 * edge), edge}, 12).occupied;
}

TEST(PointSpacing,
     is_that_of_points_on_a_sphere_however_dense_they_are_and_wherever_the_cube_ends) {
  for (const int points : {2'000, 50'000, 400'000}) {
    const double expected = std::sqrt(4.0 * 3.14159265 / points);
    for (const double edge : {2.1, 3.0, 4.1}) {
      const float spacing =
          point_spacing(occupied_by(points, edge), edge, static_cast<std::uint64_t>(points));
      EXPECT_NEAR(spacing / expected, 1.0, 0.25) << points << " points, cube " << edge;
    }
  }
}

TEST(PointSpacing, is_unknown_for_no_points_or_one) {
  EXPECT_EQ(point_spacing({}, 1.0, 0), 0.0f);
  EXPECT_EQ(point_spacing(std::vector<std::uint32_t>{1, 1, 1}, 1.0, 1), 0.0f);
}

TEST(PointSpacing, of_points_that_coincide_is_small) {
  const std::vector<std::uint32_t> one_path(13, 1);
  EXPECT_LT(point_spacing(one_path, 1.0, 1000), 1e-4f);
}

}  // namespace
}  // namespace pointreel::point_spacing_test
