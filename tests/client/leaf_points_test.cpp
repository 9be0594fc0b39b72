#include "client/prepare/leaf_points.h"

#include <cmath>
#include <vector>

#include <gtest/gtest.h>

namespace pointreel::leaf_points_test {
namespace {

const Cube kCube{{5.0, 0.0, 0.0}, 8.0};

/// A hundred points on each cell of a floor at this height, with these radii.
PointCloud floor_at(float height, float radius) {
  PointCloud cloud;
  cloud.origin = {1.0, 0.0, 0.0};
  for (int x = 0; x < 80; ++x)
    for (int z = 0; z < 80; ++z) {
      cloud.positions.emplace_back(4.05f + 0.1f * static_cast<float>(x), height,
                                   0.05f + 0.1f * static_cast<float>(z));
      cloud.radii.push_back(radius);
    }
  return cloud;
}

TEST(LeafPoints, lie_at_their_mean_height_within_the_cell) {
  for (const float height : {3.1f, 3.5f, 3.9f}) {
    const PointCloud cloud = floor_at(height, 1.0f);
    const SortedPoints sorted = sort_points(cloud, kCube, 5);
    const Svo svo = build_svo(sorted, 3);
    ASSERT_EQ(svo.leaf_count(), 64u);
    const std::vector<glm::i16vec3> down(64, glm::i16vec3(0, -32767, 0));
    for (const float one : point_heights(svo, cloud, sorted, down))
      EXPECT_NEAR(one, 3.5f - height, 1e-4f);
    const std::vector<glm::i16vec3> unknown(64, glm::i16vec3(0));
    for (const float one : point_heights(svo, cloud, sorted, unknown)) EXPECT_EQ(one, 0.0f);
  }
}

TEST(LeafPoints, give_leaves_their_radii_but_none_that_leaves_gaps) {
  for (const float radius : {0.2f, 2.0f}) {
    PointCloud cloud = floor_at(3.5f, radius);
    const SortedPoints sorted = sort_points(cloud, kCube, 5);
    const Svo svo = build_svo(sorted, 3);
    const std::vector<float> radii = own_radii(svo, cloud, sorted);
    ASSERT_EQ(radii.size(), 64u);
    for (const float one : radii) EXPECT_NEAR(one, std::max(radius, 0.5f * std::sqrt(3.0f)), 1e-5f);
  }
}

}  // namespace
}  // namespace pointreel::leaf_points_test
