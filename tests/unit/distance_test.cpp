#include "common/surface/distance.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include <gtest/gtest.h>

namespace pointreel {
namespace {

PointCloud random_cloud(std::size_t n, unsigned seed, const glm::dvec3& origin) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> uniform(-1.0f, 1.0f);
  PointCloud cloud;
  cloud.origin = origin;
  for (std::size_t i = 0; i < n; ++i) {
    cloud.positions.emplace_back(uniform(random), uniform(random), uniform(random));
  }
  return cloud;
}

OneWayDistance brute_force(const PointCloud& from, const PointCloud& to) {
  OneWayDistance result;
  for (std::size_t i = 0; i < from.size(); ++i) {
    double nearest = std::numeric_limits<double>::infinity();
    for (std::size_t k = 0; k < to.size(); ++k) {
      nearest = std::min(nearest, glm::length(from.world(i) - to.world(k)));
    }
    result.mean_squared += nearest * nearest / static_cast<double>(from.size());
    result.max = std::max(result.max, nearest);
  }
  return result;
}

TEST(Distance, agrees_with_brute_force_whatever_the_origins) {
  for (const double offset : {0.0, 1e6}) {
    const PointCloud a = random_cloud(700, 1, glm::dvec3(offset, -offset, 0.25));
    const PointCloud b = random_cloud(450, 2, glm::dvec3(offset + 0.5, -offset, 0.0));
    const Result<CloudDistance> distance = cloud_distance(a, b);
    ASSERT_TRUE(distance.has_value());
    const OneWayDistance ab = brute_force(a, b), ba = brute_force(b, a);
    EXPECT_NEAR(distance->a_to_b.mean_squared, ab.mean_squared, 1e-8);
    EXPECT_NEAR(distance->b_to_a.mean_squared, ba.mean_squared, 1e-8);
    EXPECT_NEAR(distance->a_to_b.max, ab.max, 1e-8);
    EXPECT_NEAR(distance->b_to_a.max, ba.max, 1e-8);
    EXPECT_NE(ab.max, ba.max);
    EXPECT_EQ(distance->d1(),
              std::max(distance->a_to_b.mean_squared, distance->b_to_a.mean_squared));
    EXPECT_EQ(distance->max(), std::max(distance->a_to_b.max, distance->b_to_a.max));
  }
}

TEST(Distance, of_a_cloud_to_itself_is_zero) {
  PointCloud cloud = random_cloud(100, 3, glm::dvec3(5.0));
  cloud.positions.push_back(cloud.positions.front());
  const Result<CloudDistance> distance = cloud_distance(cloud, cloud);
  ASSERT_TRUE(distance.has_value());
  EXPECT_EQ(distance->d1(), 0.0);
  EXPECT_EQ(distance->max(), 0.0);
  EXPECT_EQ(d1_psnr(distance->d1(), 1023.0), std::numeric_limits<double>::infinity());
}

TEST(Distance, sees_a_point_that_only_one_cloud_has) {
  PointCloud a, b;
  a.positions = {{0, 0, 0}, {0, 1, 0}};
  b.positions = {{0, 0, 0}, {0, 1, 0}, {3, 0, 4}, {0, 1, 0}};
  const Result<CloudDistance> distance = cloud_distance(a, b);
  ASSERT_TRUE(distance.has_value());
  EXPECT_EQ(distance->a_to_b.mean_squared, 0.0);
  EXPECT_EQ(distance->d1(), 25.0 / 4.0);
  EXPECT_EQ(distance->max(), 5.0);
}

TEST(Distance, gives_a_peak_ratio_as_mpeg_defines_it) {
  EXPECT_NEAR(d1_psnr(1.0, 1023.0), 64.97, 0.01);
  EXPECT_NEAR(d1_psnr(3.0, 1.0), 0.0, 1e-12);
}

TEST(Distance, to_a_cloud_without_points_is_an_error) {
  const PointCloud cloud = random_cloud(3, 4, glm::dvec3(0.0));
  EXPECT_FALSE(cloud_distance(cloud, {}).has_value());
  EXPECT_FALSE(cloud_distance({}, cloud).has_value());
}

}  // namespace
}  // namespace pointreel
