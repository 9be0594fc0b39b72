#include "client/prepare/node_radii.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "client/prepare/tree_radii.h"
#include "codec/core/build.h"
#include "tests/executors.h"

namespace pointreel::node_radii_test {
namespace {

Svo tree(const std::vector<glm::vec3>& positions, int depth) {
  PointCloud cloud;
  cloud.positions = positions;
  return build_svo(sort_points(cloud, Cube{glm::dvec3(0.0), 1.0}), depth);
}

std::vector<glm::vec3> plane(int points_along, float height) {
  std::vector<glm::vec3> positions;
  for (int i = 0; i < points_along * points_along; ++i) {
    const float x = static_cast<float>(i % points_along) + 0.5f,
                z = static_cast<float>(i / points_along) + 0.5f;
    positions.push_back(glm::vec3(x, 0.0f, z) / static_cast<float>(points_along) +
                        glm::vec3(0.0f, height, 0.0f));
  }
  return positions;
}

TEST(NodeRadii, keep_those_of_leaves_and_give_parents_the_area_of_their_children) {
  const Svo svo = tree(plane(64, 0.3f), 6);
  ASSERT_EQ(svo.leaf_count(), 64u * 64u);
  const float radius = 0.8f / 64.0f;
  const auto radii = node_radii(svo, std::vector<float>(svo.leaf_count(), radius));
  ASSERT_EQ(radii.size(), svo.node_count());
  for (int level = 0; level <= 6; ++level) {
    for (std::uint32_t i = 0; i < svo.node_count(level); ++i) {
      // Each node has four children, so the radius doubles.
      const float expected = radius * static_cast<float>(1 << (6 - level));
      ASSERT_NEAR(radii[svo.level_begin[static_cast<std::size_t>(level)] + i], expected, 1e-5);
    }
  }
}

TEST(NodeRadii, equal_that_of_an_only_child) {
  const Svo svo = tree({{0.1f, 0.2f, 0.3f}}, 8);
  for (const float radius : node_radii(svo, {0.25f})) EXPECT_EQ(radius, 0.25f);
}

TEST(NodeRadii, do_not_grow_with_noise_that_thickens_a_surface) {
  std::vector<glm::vec3> positions;
  for (int sheet = 0; sheet < 16; ++sheet) {
    const auto more = plane(64, 0.25f + static_cast<float>(sheet) / 64.0f);
    positions.insert(positions.end(), more.begin(), more.end());
  }
  const Svo svo = tree(positions, 6);
  const auto radii = node_radii(svo, std::vector<float>(svo.leaf_count(), 0.8f / 64.0f));
  for (int level = 0; level < 6; ++level) {
    for (std::uint32_t i = 0; i < svo.node_count(level); ++i) {
      ASSERT_LE(radii[svo.level_begin[static_cast<std::size_t>(level)] + i],
                1.001 * svo.cell_size(level));
    }
  }
}

TEST(NodeRadii, are_none_for_an_empty_tree) { EXPECT_TRUE(node_radii(Svo{}, {}).empty()); }

TEST(NodeRadii, cover_a_closed_surface_on_every_level) {
  std::mt19937 random(7);
  std::normal_distribution<float> gauss;
  std::vector<glm::vec3> positions;
  for (int i = 0; i < 60'000; ++i) {
    const glm::vec3 n(gauss(random), gauss(random), gauss(random));
    positions.push_back(0.5f + 0.45f * glm::normalize(n));
  }
  const Svo svo = tree(positions, 9);
  const auto radii = node_radii(svo, leaf_radii(svo));
  const double area = 4.0 * 3.14159265 * 0.45 * 0.45;
  const auto area_at = [&](int level) {
    double sum = 0.0;
    for (std::uint32_t i = 0; i < svo.node_count(level); ++i) {
      const double r = radii[svo.level_begin[static_cast<std::size_t>(level)] + i];
      sum += r * r;
    }
    return sum;
  };
  for (int level = 3; level <= 9; ++level) {
    EXPECT_GT(area_at(level), 0.65 * area) << level;
    EXPECT_LT(area_at(level), 1.01 * area_at(9)) << level;
  }
}

TEST(NodeRadii, are_the_same_for_any_number_of_threads) {
  std::mt19937 random(3);
  std::uniform_real_distribution<float> anywhere(0.0f, 1.0f);
  std::vector<glm::vec3> positions;
  for (int i = 0; i < 150'000; ++i)
    positions.emplace_back(anywhere(random), anywhere(random), anywhere(random));
  const Svo svo = tree(positions, 8);
  const std::vector<float> leaves = leaf_radii(svo), expected = node_radii(svo, leaves);
  for (const Executor& executor : some_executors())
    EXPECT_EQ(node_radii(svo, leaves, executor), expected);
}

}  // namespace
}  // namespace pointreel::node_radii_test
