#include "codec/octree/normal_noise.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "codec/core/build.h"
#include "codec/octree/leaf_attributes.h"
#include "codec/octree/normal_space.h"
#include "pointreel/draco.h"

namespace pointreel::normal_noise_test {
namespace {

/// Random points on a sphere of radius 1, whose normals have noise of so many radians in each
/// tangential direction.
PointCloud noisy_sphere(int points, double noise) {
  std::mt19937 random(1);
  std::normal_distribution<double> gauss;
  const auto vector = [&] { return glm::dvec3(gauss(random), gauss(random), gauss(random)); };
  PointCloud cloud;
  for (int i = 0; i < points; ++i) {
    const glm::dvec3 at = glm::normalize(vector());
    const glm::dvec3 error = noise * vector();
    cloud.positions.emplace_back(at);
    cloud.normals.emplace_back(glm::normalize(at + error - glm::dot(error, at) * at));
  }
  return cloud;
}

double noise_of(const PointCloud& cloud) {
  const SortedToDepth points =
      sort_to_depth(cloud, bounding_cube(bounds(cloud)), DepthRule::by_delta(0.05)).value();
  const Svo svo = build_svo(points.sorted, points.depth);
  std::vector<Short4> leaves;
  for (const glm::i16vec3& normal : mean_leaf_normals(svo, cloud, points.sorted)) {
    leaves.push_back(value_from_normal(normal));
  }
  return normal_noise(svo, leaves) / kUnitNormal;
}

TEST(NormalNoise, is_found) {
  for (const double noise : {0.02, 0.1, 0.3}) {
    EXPECT_NEAR(noise_of(noisy_sphere(20'000, noise)) / noise, 1.0, 0.1) << noise;
  }
  EXPECT_LT(noise_of(noisy_sphere(20'000, 0.0)), 0.01) << "the sphere's curvature is no noise";
}

TEST(NormalNoise, is_zero_if_there_are_too_few_normals) {
  EXPECT_EQ(noise_of(noisy_sphere(1, 0.3)), 0.0);
  EXPECT_EQ(noise_of(noisy_sphere(60, 0.3)), 0.0);
  PointCloud unknown = noisy_sphere(20'000, 0.3);
  for (glm::vec3& normal : unknown.normals) normal = glm::vec3(0.0f);
  EXPECT_EQ(noise_of(unknown), 0.0);
}

TEST(NormalNoise, is_not_sent_and_clean_normals_keep_their_quality) {
  const auto sizes = [](double noise) {
    const PointCloud cloud = noisy_sphere(20'000, noise);
    const auto size = [&](bool follow) {
      OctreeOptions options;
      options.normals_follow_noise = follow;
      const auto frame = encode_frame(cloud, bounding_cube(bounds(cloud)), {options});
      std::size_t bytes = 0;
      for (const auto& layer : frame->layers) bytes += layer.normals.size();
      return bytes;
    };
    return std::pair(size(true), size(false));
  };
  const auto [clean, clean_whole] = sizes(0.01);
  EXPECT_EQ(clean, clean_whole);
  const auto [noisy, noisy_whole] = sizes(0.2);
  EXPECT_LT(2 * noisy, noisy_whole);
}

}  // namespace
}  // namespace pointreel::normal_noise_test
