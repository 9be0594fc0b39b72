#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "codec/files/ply.h"
#include "datasets_synthetic/motion.h"
#include "datasets_synthetic/samplers/uniform.h"
#include "datasets_synthetic/sequences.h"
#include "tests/synth/sampled_bytes.h"

namespace pointreel::sampler_test {
namespace {

constexpr double kPi = 3.14159265358979;

Surface alone(const Primitive& primitive) { return {{primitive}, {{0, 0, 0.0}}}; }

/// Pearson's chi-squared statistic of counts that should be equal.
double chi_square(const std::vector<int>& counts, double total) {
  const double expected = total / static_cast<double>(counts.size());
  double sum = 0.0;
  for (const int count : counts) sum += (count - expected) * (count - expected) / expected;
  return sum;
}

TEST(UniformSampler, points_lie_on_the_surface_of_the_walking_figure) {
  const Body body = pose_body(walk(0.4));
  const auto points = sample_uniform(body.surface, 20000, 1);
  ASSERT_TRUE(points) << points.error().message;
  ASSERT_EQ(points->size(), 20000u);
  for (const SurfacePoint& point : *points) {
    const SurfaceDistance at = distance_to(body.surface, point.position);  // all parts, no grid
    EXPECT_LE(std::abs(at.distance.value), kSurfaceTolerance);
    EXPECT_NEAR(glm::length(point.normal), 1.0, 1e-12);
  }
}

TEST(UniformSampler, normals_agree_with_finite_differences_except_in_creases) {
  const Body body = pose_body(walk(0.4));
  const auto points = sample_uniform(body.surface, 5000, 2);
  int apart = 0;
  for (const SurfacePoint& point : points.value()) {
    constexpr double kStep = 1e-6;
    glm::dvec3 gradient;
    for (int axis = 0; axis < 3; ++axis) {
      glm::dvec3 step(0.0);
      step[axis] = kStep;
      gradient[axis] = distance_to(body.surface, point.position + step).distance.value -
                       distance_to(body.surface, point.position - step).distance.value;
    }
    if (glm::dot(point.normal, gradient) < 0.99999 * glm::length(gradient)) ++apart;
  }
  EXPECT_LE(apart, 5);
}

TEST(UniformSampler, slices_of_a_ball_of_equal_height_hold_equally_many_points) {
  // Archimedes: the area of a slice of a sphere is proportional to its height.
  const auto points =
      sample_uniform(alone(RoundCone{{0.3, 0.1, 0}, {0.3, 0.1, 0}, 0.25, 0.25}), 100000, 3);
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<int> slices(50);
    for (const SurfacePoint& point : points.value()) {
      const double height = point.position[axis] - (axis == 0 ? 0.3 : axis == 1 ? 0.1 : 0.0);
      ++slices[static_cast<std::size_t>(std::min(49.0, (height + 0.25) / 0.5 * 50.0))];
    }
    EXPECT_LT(chi_square(slices, 100000), 49 + 5 * std::sqrt(2.0 * 49)) << axis;
  }
}

TEST(UniformSampler, points_on_a_thin_capsule_are_shared_by_area) {
  // As thin as a finger, where the curvature of the shell matters most.
  const double radius = 0.012, length = 0.08;
  const auto points =
      sample_uniform(alone(RoundCone{{0, 0, 0}, {0, length, 0}, radius, radius}), 100000, 4);
  double side = 0;
  for (const SurfacePoint& point : points.value()) {
    side += point.position.y > 0 && point.position.y < length;
  }
  const double side_area = 2 * kPi * radius * length, end_area = 4 * kPi * radius * radius;
  EXPECT_NEAR(side / 100000, side_area / (side_area + end_area), 0.008);
}

TEST(UniformSampler, points_are_as_dense_on_fillets_as_elsewhere) {
  // Two capsules that cross and blend: the density per area in small balls around points of the
  // surface must not depend on where they lie. The area in each ball is found by counting the cells
  // of a regular grid near the surface (the coarea formula).
  const Surface surface{{RoundCone{{-0.1, 0, 0}, {0.1, 0, 0}, 0.03, 0.03},
                         RoundCone{{0, -0.1, 0}, {0, 0.1, 0}, 0.03, 0.03}},
                        {{0, 1, 0.03}}};
  const auto points = sample_uniform(surface, 200000, 5);
  const auto share_of_points = [&](const glm::dvec3& center, double radius) {
    double inside = 0;
    for (const SurfacePoint& point : points.value()) {
      inside += glm::length(point.position - center) < radius;
    }
    return inside / 200000;
  };
  // The volume of the shell |distance| < kHalf, weighted by the gradient, divided by its thickness.
  const auto area = [&](const glm::dvec3& from, const glm::dvec3& to, const auto& holds) {
    constexpr double kStep = 0.001, kHalf = 0.002;
    double sum = 0.0;
    for (double x = from.x + 0.5 * kStep; x < to.x; x += kStep) {
      for (double y = from.y + 0.5 * kStep; y < to.y; y += kStep) {
        for (double z = from.z + 0.5 * kStep; z < to.z; z += kStep) {
          if (!holds(glm::dvec3(x, y, z))) continue;
          const Distance at = distance_to(surface, {x, y, z}).distance;
          if (std::abs(at.value) < kHalf) sum += glm::length(at.gradient);
        }
      }
    }
    return sum * kStep * kStep * kStep / (2.0 * kHalf);
  };
  // The eight octants are equal.
  const double all =
      8.0 * area({0, 0, 0}, {0.14, 0.14, 0.05}, [](const glm::dvec3&) { return true; });
  for (const glm::dvec3& center :
       {glm::dvec3(0.03, 0.03, 0), glm::dvec3(-0.03, 0.03, 0.01), glm::dvec3(0, 0, 0.03),
        glm::dvec3(0.08, 0.03, 0), glm::dvec3(0, -0.13, 0)}) {
    const double expected =
        area(center - 0.02, center + 0.02,
             [&](const glm::dvec3& p) { return glm::length(p - center) < 0.02; }) /
        all;
    EXPECT_NEAR(share_of_points(center, 0.02) / expected, 1.0, 0.04) << center.x << " " << center.y;
  }
}

TEST(UniformSampler, a_smaller_sample_is_a_prefix_of_a_larger_one) {
  const Body body = pose_body(Pose{});
  const auto few = sample_uniform(body.surface, 100, 9);
  const auto many = sample_uniform(body.surface, 7000, 9);
  for (std::size_t i = 0; i < 100; ++i) EXPECT_EQ((*few)[i].position, (*many)[i].position);
}

TEST(UniformSampler, a_seed_gives_the_same_bytes_on_one_thread_and_on_two) {
  SequenceOptions options;
  options.sampler = Sampler::uniform;
  options.points = 20000;
  options.noise = 0.001;
  const Bytes one = sampled_bytes(options, 1);
  EXPECT_GT(one.size(), 20000u * 27u);
  EXPECT_EQ(one, sampled_bytes(options, 2));
  options.seed = 2;
  EXPECT_NE(one, sampled_bytes(options, 2));
}

TEST(UniformSampler, refuses_a_shape_without_a_surface) {
  EXPECT_FALSE(sample_uniform(Surface{}, 10, 1));
  EXPECT_FALSE(sample_uniform(alone(RoundCone{{0, 0, 0}, {100, 0, 0}, 1, 1}), 10, 1));
  EXPECT_FALSE(sample_uniform(alone(RoundCone{{NAN, 0, 0}, {1, 0, 0}, 1, 1}), 10, 1));
  EXPECT_TRUE(sample_uniform(alone(RoundCone{{0, 0, 0}, {1, 0, 0}, 1, 1}), 0, 1)->empty());
}

}  // namespace
}  // namespace pointreel::sampler_test
