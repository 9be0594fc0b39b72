#include "client/prepare/tree_radii.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

#include "codec/core/build.h"

namespace pointreel::tree_radii_test {
namespace {

/// Random points on a sphere of radius 1.
PointCloud sphere_cloud(std::size_t points) {
  std::mt19937 random(3);
  std::normal_distribution<float> gauss;
  PointCloud cloud;
  for (std::size_t i = 0; i < points; ++i)
    cloud.positions.push_back(
        glm::normalize(glm::vec3(gauss(random), gauss(random), gauss(random))));
  return cloud;
}

const Cube kCube{glm::dvec3(-1.1), 2.2};

Svo sphere(std::size_t points, int depth) {
  return build_svo(sort_points(sphere_cloud(points), kCube, depth), depth);
}

float median(std::vector<float> values) {
  std::nth_element(values.begin(), values.begin() + values.size() / 2, values.end());
  return values[values.size() / 2];
}

TEST(LeafRadii, cover_the_leaves_of_a_closed_surface) {
  const Svo svo = sphere(400'000, 6);
  const auto radii = leaf_radii(svo);
  ASSERT_EQ(radii.size(), svo.leaf_count());
  const double half_diagonal = 0.5 * std::sqrt(3.0) * svo.cell_size(6);
  EXPECT_GE(*std::min_element(radii.begin(), radii.end()), 0.999 * half_diagonal);
  EXPECT_LE(median(radii), 1.1 * half_diagonal);
  EXPECT_LE(*std::max_element(radii.begin(), radii.end()), 2.0 * half_diagonal);
}

TEST(LeafRadii, bridge_the_gaps_between_sparse_leaves) {
  for (const int depth : {9, 12, 16}) {
    const Svo svo = sphere(20'000, depth);
    const auto radii = leaf_radii(svo);
    ASSERT_EQ(radii.size(), svo.leaf_count());
    const double spacing = std::sqrt(4.0 * std::numbers::pi / svo.leaf_count());
    EXPECT_NEAR(median(radii), spacing, 0.25 * spacing) << depth;
    EXPECT_LE(*std::max_element(radii.begin(), radii.end()), 4.0 * spacing) << depth;
  }
}

TEST(LeafRadii, reach_across_the_gaps_between_curves) {
  // A grid of curves on a plane, as the pattern of a scanner draws it: 24 gaps of 1/24, and 40
  // points from one crossing to the next.
  constexpr int kGaps = 24, kPoints = 40 * kGaps;
  PointCloud cloud;
  for (int curve = 0; curve <= kGaps; ++curve) {
    for (int i = 0; i < kPoints; ++i) {
      const float across = static_cast<float>(curve) / kGaps;
      const float along = static_cast<float>(i) / kPoints;
      cloud.positions.push_back({across, along, 0.5f});
      cloud.positions.push_back({along, across, 0.5f});
    }
  }
  const Svo svo = build_svo(sort_points(cloud, Cube{glm::dvec3(0.0), 1.0}, 11), 11);
  const auto radii = leaf_radii(svo);
  // Drawn at twice the size, they close the middle of a mesh.
  EXPECT_GT(2.0f * *std::min_element(radii.begin(), radii.end()), 0.5f / kGaps);
  EXPECT_LT(*std::max_element(radii.begin(), radii.end()), 1.0f / kGaps);
}

TEST(LeafRadii, follow_the_local_density) {
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

TEST(PointRadii, equal_the_spacing_of_the_points_at_any_depth_of_the_tree) {
  const PointCloud cloud = sphere_cloud(20'000);
  const double spacing = std::sqrt(4.0 * std::numbers::pi / 20'000);
  const SortedPoints sorted = sort_points(cloud, kCube, 14);
  for (const int depth : {4, 6, 9, 14}) {
    const auto radii = point_radii(build_svo(sorted, depth), sorted);
    ASSERT_EQ(radii.size(), cloud.size());
    EXPECT_NEAR(median(radii), spacing, 0.3 * spacing) << depth;
    EXPECT_GT(*std::min_element(radii.begin(), radii.end()), 0.3 * spacing) << depth;
    EXPECT_LT(*std::max_element(radii.begin(), radii.end()), 4.0 * spacing) << depth;
  }
}

TEST(PointRadii, are_bounded_for_stray_points) {
  PointCloud cloud = sphere_cloud(20'000);
  for (int i = 0; i < 20; ++i)
    cloud.positions.push_back(glm::vec3(0.9f - 0.09f * static_cast<float>(i), 0.05f, 0.0f));
  const double spacing = std::sqrt(4.0 * std::numbers::pi / 20'000);
  const SortedPoints sorted = sort_points(cloud, kCube, 14);
  const auto radii = point_radii(build_svo(sorted, 9), sorted);
  EXPECT_LT(*std::max_element(radii.begin(), radii.end()), 4.0 * spacing);
}

TEST(PointRadii, have_the_order_of_the_cloud) {
  // Dense where x < 0, a sixteenth of that elsewhere, in random order.
  std::mt19937 random(6);
  std::uniform_real_distribution<float> uniform;
  PointCloud cloud;
  for (int i = 0; i < 40'000; ++i) {
    const float x = 2.0f * uniform(random) - 1.0f;
    if (x < 0.0f || i % 16 == 0) cloud.positions.push_back({x, uniform(random), 0.25f});
  }
  const SortedPoints sorted = sort_points(cloud, Cube{{-1.0, 0.0, 0.0}, 2.0}, 12);
  const auto radii = point_radii(build_svo(sorted, 10), sorted);
  std::vector<float> dense, sparse;
  for (std::size_t i = 0; i < radii.size(); ++i)
    (cloud.positions[i].x < 0.0f ? dense : sparse).push_back(radii[i]);
  EXPECT_GT(median(sparse), 2.0f * median(dense));
  EXPECT_NEAR(median(dense), std::sqrt(1.0 / static_cast<double>(dense.size())), 0.003);
}

TEST(PointRadii, count_duplicates_once) {
  PointCloud cloud = sphere_cloud(5'000);
  const SortedPoints once = sort_points(cloud, kCube, 14);
  const auto radii = point_radii(build_svo(once, 8), once);
  const std::vector<glm::vec3> positions = cloud.positions;
  for (int i = 0; i < 2; ++i)
    cloud.positions.insert(cloud.positions.end(), positions.begin(), positions.end());
  const SortedPoints thrice = sort_points(cloud, kCube, 14);
  const auto same = point_radii(build_svo(thrice, 8), thrice);
  for (std::size_t i = 0; i < same.size(); ++i) ASSERT_EQ(same[i], radii[i % 5'000]);
}

TEST(PointRadii, are_positive_for_a_single_point_and_absent_without_points) {
  PointCloud one;
  one.positions = {glm::vec3(0.5f)};
  const Cube cube{glm::dvec3(0.0), 1.0};
  const SortedPoints sorted = sort_points(one, cube, 21);
  for (const int depth : {0, 5, 21}) EXPECT_GT(point_radii(build_svo(sorted, depth), sorted)[0], 0);
  const SortedPoints none = sort_points(PointCloud{}, cube, 3);
  EXPECT_TRUE(point_radii(build_svo(none, 3), none).empty());
}

TEST(LeafRadii, show_a_single_point_however_fine_its_cell_is) {
  PointCloud one;
  one.positions = {glm::vec3(0.5f)};
  const Cube cube{glm::dvec3(0.0), 1.0};
  for (const int depth : {0, 5, 13, 21}) {
    const auto radii = leaf_radii(build_svo(sort_points(one, cube, depth), depth));
    ASSERT_EQ(radii.size(), 1u);
    EXPECT_GE(radii[0], 0.5 * std::sqrt(3.0) / (1 << depth) - 1e-6) << depth;  // fills its cell
    EXPECT_GE(radii[0], 0.02) << depth;
    if (depth >= 5) {
      EXPECT_LE(radii[0], 0.03) << depth;
    }
  }
  EXPECT_TRUE(leaf_radii(build_svo(sort_points(PointCloud{}, cube, 3), 3)).empty());
}

TEST(LeafRadii, join_the_points_of_a_line_whose_cells_are_much_finer_than_their_distances) {
  PointCloud line;
  for (int i = 0; i < 100; ++i)
    line.positions.emplace_back((static_cast<float>(i) + 0.5f) / 100.0f, 0.3f, 0.4f);
  const Cube cube{glm::dvec3(0.0), 1.0};
  for (const int depth : {7, 10, 16}) {
    const auto radii = leaf_radii(build_svo(sort_points(line, cube, depth), depth));
    for (const float radius : radii) {
      EXPECT_GT(radius, 0.005f) << depth;
      EXPECT_LT(radius, 0.02f) << depth;
    }
  }
}

}  // namespace
}  // namespace pointreel::tree_radii_test
