#include "codec/surface/algebraic_sphere.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

namespace pointreel::algebraic_sphere_test {
namespace {

glm::dvec3 random_direction(std::mt19937& random) {
  std::normal_distribution<double> normal;
  return glm::normalize(glm::dvec3(normal(random), normal(random), normal(random)));
}

/// Points of a sphere, with equal weights.
SphereSums samples_of_sphere(const glm::dvec3& centre, double radius, int count) {
  std::mt19937 random(1);
  SphereSums sums;
  for (int i = 0; i < count; ++i) {
    const glm::dvec3 normal = random_direction(random);
    sums.add(centre + radius * normal, normal, 1.0);
  }
  return sums;
}

TEST(AlgebraicSphere, goes_through_the_points_of_a_sphere) {
  const glm::dvec3 centre(0.3, -0.2, 0.7);
  for (const double radius : {0.1, 1.0, 1e3}) {
    const auto sphere = fit_sphere(samples_of_sphere(centre, radius, 50), 1.0);
    ASSERT_TRUE(sphere);
    std::mt19937 random(2);
    for (int i = 0; i < 20; ++i) {
      const glm::dvec3 direction = random_direction(random);
      const auto found = sphere->project(centre + (0.5 + 0.1 * i) * radius * direction);
      ASSERT_TRUE(found);
      EXPECT_NEAR(glm::length(found->position - centre), radius, 1e-9 * radius);
      EXPECT_NEAR(glm::dot(found->normal, direction), 1.0, 1e-12);
    }
  }
}

TEST(AlgebraicSphere, is_a_plane_for_points_of_a_plane_and_for_a_beta_of_zero) {
  SphereSums flat;
  for (const double x : {-1.0, 0.0, 1.0}) {
    for (const double z : {-1.0, 0.5, 1.0}) flat.add({x, 2.0, z}, {0.0, 1.0, 0.0}, 1.0 + x * z / 4);
  }
  const auto plane = fit_sphere(flat, 1.0);
  ASSERT_TRUE(plane);
  EXPECT_NEAR(plane->u4, 0.0, 1e-15);
  EXPECT_NEAR(plane->project({5.0, 7.0, 5.0})->position.y, 2.0, 1e-12);
  EXPECT_EQ(fit_sphere(samples_of_sphere({}, 1.0, 50), 0.0)->u4, 0.0);
}

TEST(AlgebraicSphere, beta_scales_the_curvature) {
  const SphereSums sums = samples_of_sphere({0.1, 0.0, 0.0}, 1.0, 50);
  const double whole = fit_sphere(sums, 1.0)->u4;
  EXPECT_NEAR(fit_sphere(sums, 0.5)->u4, 0.5 * whole, 1e-15);
  EXPECT_NEAR(fit_sphere(sums, -2.0)->u4, -2.0 * whole, 1e-15);
}

TEST(AlgebraicSphere, is_a_plane_for_points_on_one_spot) {
  for (const int count : {1, 100}) {
    SphereSums sums;
    for (int i = 0; i < count; ++i) sums.add({1e-3, 2e-3, 3e-3}, {0.0, 0.0, 1.0}, 0.3);
    const auto sphere = fit_sphere(sums, 1.0);
    ASSERT_TRUE(sphere);
    EXPECT_EQ(sphere->u4, 0.0);
    EXPECT_NEAR(sphere->project({})->position.z, 3e-3, 1e-15);
  }
}

TEST(AlgebraicSphere, does_not_exist_without_weight_or_direction) {
  EXPECT_FALSE(fit_sphere({}, 1.0));
  SphereSums opposed;
  opposed.add({0.0, 0.0, 0.1}, {0.0, 0.0, 1.0}, 1.0);
  opposed.add({0.0, 0.0, -0.1}, {0.0, 0.0, -1.0}, 1.0);
  EXPECT_FALSE(fit_sphere(opposed, 1.0));
}

TEST(AlgebraicSphere, projects_alike_with_and_without_a_tiny_curvature) {
  const AlgebraicSphere plane{0.25, {0.0, 1.0, 0.0}, 0.0};
  for (const double u4 : {1e-300, 1e-18, -1e-18}) {
    const AlgebraicSphere curved{0.25, {0.0, 1.0, 0.0}, u4};
    EXPECT_NEAR(curved.project({})->position.y, plane.project({})->position.y, 1e-15);
  }
  EXPECT_EQ(plane.project({})->position.y, -0.25);
}

TEST(AlgebraicSphere, without_a_real_point_leads_to_the_least_distance) {
  // 1 + y + y^2 has no root, and its minimum at -1/2.
  const AlgebraicSphere imaginary{1.0, {0.0, 1.0, 0.0}, 1.0};
  const auto found = imaginary.project({});
  ASSERT_TRUE(found);
  EXPECT_TRUE(std::isfinite(found->position.y));
  EXPECT_NEAR(glm::length(found->normal), 1.0, 1e-12);
}

TEST(AlgebraicSphere, has_a_normal_in_its_centre_or_none_at_all) {
  const AlgebraicSphere unit{-1.0, {}, 1.0};
  EXPECT_FALSE(unit.project({}));
  const auto near = unit.project({0.0, 1e-9, 0.0});
  ASSERT_TRUE(near);
  EXPECT_NEAR(near->position.y, 1.0, 1e-6);
}

}  // namespace
}  // namespace pointreel::algebraic_sphere_test
