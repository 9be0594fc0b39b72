#include "client/playback/leaf_radii.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

namespace pointreel {
namespace {

/// The tree of random points on a sphere of radius 1, and how many points those are.
Svo sphere(std::size_t points, int depth) {
  std::mt19937 random(3);
  std::normal_distribution<float> gauss;
  PointCloud cloud;
  for (std::size_t i = 0; i < points; ++i)
    cloud.positions.push_back(
        glm::normalize(glm::vec3(gauss(random), gauss(random), gauss(random))));
  return build_svo(sort_points(cloud, Cube{glm::dvec3(-1.1), 2.2}, depth), depth);
}

float median(std::vector<float> values) {
  std::nth_element(values.begin(), values.begin() + values.size() / 2, values.end());
  return values[values.size() / 2];
}

TEST(LeafRadii, CoverTheLeavesOfAClosedSurface) {
  const Svo svo = sphere(400'000, 6);
  const auto radii = leaf_radii(svo);
  ASSERT_EQ(radii.size(), svo.leaf_count());
  const double half_diagonal = 0.5 * std::sqrt(3.0) * svo.cell_size(6);
  EXPECT_GE(*std::min_element(radii.begin(), radii.end()), 0.999 * half_diagonal);
  EXPECT_LE(median(radii), 1.1 * half_diagonal);
  EXPECT_LE(*std::max_element(radii.begin(), radii.end()), 2.0 * half_diagonal);
}

TEST(LeafRadii, BridgeTheGapsBetweenSparseLeaves) {
  for (const int depth : {9, 12, 16}) {
    const Svo svo = sphere(20'000, depth);
    const auto radii = leaf_radii(svo);
    ASSERT_EQ(radii.size(), svo.leaf_count());
    const double spacing = std::sqrt(4.0 * std::numbers::pi / svo.leaf_count());
    EXPECT_NEAR(median(radii), spacing, 0.25 * spacing) << depth;
    EXPECT_LE(*std::max_element(radii.begin(), radii.end()), 3.0 * spacing) << depth;
  }
}

TEST(LeafRadii, FollowTheDensity) {
  // The half with x > 0 has a sixteenth of the points.
  std::mt19937 random(4);
  std::uniform_real_distribution<float> uniform;
  PointCloud cloud;
  for (int i = 0; i < 40'000; ++i) {
    const float x = 2.0f * uniform(random) - 1.0f;
    if (x > 0.0f && i % 16 != 0) continue;
    cloud.positions.push_back({x, uniform(random), 0.25f});
  }
  const Cube cube{{-1.0, 0.0, 0.0}, 2.0};
  const SortedPoints sorted = sort_points(cloud, cube, 12);
  const Svo svo = build_svo(sorted, 12);
  const auto radii = leaf_radii(svo);
  const auto cells = leaf_cells(svo);
  std::vector<float> dense, sparse;
  for (std::size_t i = 0; i < radii.size(); ++i)
    (cells[i].x < 2048 ? dense : sparse).push_back(radii[i]);
  EXPECT_GT(median(sparse), 2.0f * median(dense));
}

TEST(LeafRadii, AreOneForASinglePointAndNoneForNone) {
  PointCloud one;
  one.positions = {glm::vec3(0.5f)};
  const Cube cube{glm::dvec3(0.0), 1.0};
  for (const int depth : {0, 5, 21}) {
    const auto radii = leaf_radii(build_svo(sort_points(one, cube, depth), depth));
    ASSERT_EQ(radii.size(), 1u);
    EXPECT_NEAR(radii[0], 0.5 * std::sqrt(3.0) / (1 << depth), 1e-6) << depth;
  }
  EXPECT_TRUE(leaf_radii(build_svo(sort_points(PointCloud{}, cube, 3), 3)).empty());
}

}  // namespace
}  // namespace pointreel
