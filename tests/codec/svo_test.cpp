#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include <gtest/gtest.h>

#include "codec/core/build.h"
#include "codec/core/morton.h"
#include "codec/core/normal_lines.h"
#include "pointreel/octree.h"
#include "tests/executors.h"
#include "tests/reference/recursive_octree.h"

namespace pointreel::svo_test {
namespace {

PointCloud random_shell(std::size_t n, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> unit(-1.0f, 1.0f);
  PointCloud cloud;
  while (cloud.size() < n) {
    const glm::vec3 p(unit(random), unit(random), unit(random));
    const float length = glm::length(p);
    if (length < 0.1f || length > 1.0f) continue;
    cloud.positions.push_back(p / length * glm::vec3(0.4f, 0.9f, 0.3f));
    cloud.normals.push_back(p / length);
    cloud.colors.push_back(glm::u16vec3(random() & 0xffff, random() & 0xffff, random() & 0xffff));
  }
  return cloud;
}

PointCloud cloud_of(std::vector<glm::vec3> positions) {
  PointCloud cloud;
  cloud.positions = std::move(positions);
  return cloud;
}

int depth_for(const PointCloud& cloud, double delta) {
  const auto points =
      sort_to_depth(cloud, bounding_cube(bounds(cloud)), DepthRule::by_delta(delta));
  EXPECT_TRUE(points) << points.error().message;
  return points ? points->depth : -1;
}

TEST(Svo, equals_the_recursive_build_of_the_paper_for_every_delta) {
  const PointCloud cloud = random_shell(20000, 1);
  // The edge is a power of two, so that the reference's halved centres are exact.
  const Cube cube{glm::dvec3(-1.0), 2.0};
  for (const double delta : {0.02, 0.05, 0.1, 0.5, 0.9}) {
    const reference::RecursiveOctree slow(cloud, cube, delta, kMaxDepth);
    const auto points = sort_to_depth(cloud, cube, DepthRule::by_delta(delta));
    ASSERT_TRUE(points);
    EXPECT_EQ(points->depth, slow.depth());
    const Svo svo = build_svo(points->sorted, points->depth);
    EXPECT_EQ(svo.leaf_count(), slow.leaf_count());
    EXPECT_EQ(svo.node_count(), slow.node_count());
    EXPECT_EQ(svo.masks, slow.masks());
  }
}

TEST(Svo, counts_occupied_cells_of_every_level) {
  const PointCloud cloud = random_shell(3000, 2);
  const SortedPoints sorted = sort_points(cloud, bounding_cube(bounds(cloud)));
  for (int level = 0; level <= kMaxDepth; ++level) {
    std::vector<std::uint64_t> cells;
    for (const KeyIndex& p : sorted.points) cells.push_back(p.key >> (3 * (kMaxDepth - level)));
    std::sort(cells.begin(), cells.end());
    cells.erase(std::unique(cells.begin(), cells.end()), cells.end());
    EXPECT_EQ(sorted.occupied[static_cast<std::size_t>(level)], cells.size()) << level;
    EXPECT_EQ(build_svo(sorted, level).leaf_count(), cells.size()) << level;
  }
}

TEST(Svo, puts_a_point_on_the_maximum_face_into_the_last_cell) {
  const PointCloud cloud = cloud_of({{0, 0, 0}, {1, 1, 1}});
  const SortedPoints sorted = sort_points(cloud, bounding_cube(bounds(cloud)));
  const std::vector<glm::uvec3> cells = leaf_cells(build_svo(sorted, 5));
  ASSERT_EQ(cells.size(), 2u);
  EXPECT_EQ(cells[0], glm::uvec3(0));
  EXPECT_EQ(cells[1], glm::uvec3(31));
}

TEST(Svo, clamps_points_outside_the_cube_however_far) {
  const PointCloud cloud = cloud_of({{-1e30f, 0.5f, 3e38f}});
  const SortedPoints sorted = sort_points(cloud, Cube{glm::dvec3(0.0), 1.0});
  EXPECT_EQ(leaf_cells(build_svo(sorted, 2)).at(0), glm::uvec3(0, 2, 3));
}

TEST(Svo, round_trips_within_half_a_cell_at_level_21_and_an_offset_of_a_million) {
  PointCloud cloud = random_shell(2000, 3);
  cloud.origin = {1e6 + 0.3, -2e6, 5e6};
  const Cube cube = bounding_cube(bounds(cloud));
  const SortedPoints sorted = sort_points(cloud, cube);
  const double cell = std::ldexp(cube.edge, -kMaxDepth);
  // Half a cell, plus the precision of a double at this offset.
  const double tolerance = 0.5 * cell + 4e-9;
  for (const KeyIndex& point : sorted.points) {
    const glm::dvec3 center = cube.origin + (glm::dvec3(morton_decode(point.key)) + 0.5) * cell;
    const glm::dvec3 error = glm::abs(center - cloud.world(point.index));
    EXPECT_LE(std::max({error.x, error.y, error.z}), tolerance);
  }
}

TEST(Svo, is_empty_without_points) {
  const SortedPoints sorted = sort_points(PointCloud{}, Cube{});
  EXPECT_EQ(*choose_depth(sorted.occupied, 0, DepthRule::by_delta(0.05)), 0);
  for (const int depth : {0, 7}) {
    const Svo svo = build_svo(sorted, depth);
    EXPECT_EQ(svo.node_count(), 0u);
    EXPECT_EQ(svo.leaf_count(), 0u);
    EXPECT_TRUE(leaf_cells(svo).empty());
  }
}

TEST(Svo, ends_at_one_cell_for_identical_points) {
  EXPECT_EQ(depth_for(cloud_of(std::vector<glm::vec3>(100, glm::vec3(3, 4, 5))), 0.0), 0);
  EXPECT_EQ(depth_for(cloud_of({{3, 4, 5}}), 0.0), 0);
}

TEST(Svo, stops_at_the_level_that_separates_all_distinct_points) {
  // Half the points coincide, so oct(h)/n never reaches 1 - delta.
  PointCloud cloud = cloud_of({{0, 0, 0}, {1, 0, 0}, {0, 0, 0}, {1, 0, 0}});
  EXPECT_EQ(depth_for(cloud, 0.05), 1);
}

TEST(Svo, is_no_deeper_because_points_are_repeated) {
  const PointCloud once = random_shell(5000, 4);
  const int depth = depth_for(once, 0.05);
  std::mt19937 random(5);
  // A float's rounding of coordinates below 1.
  std::uniform_real_distribution<float> rounding(-6e-8f, 6e-8f);
  PointCloud exactly, nearly, origins;
  for (int copy = 0; copy < 6; ++copy) {
    for (const glm::vec3& p : once.positions) {
      exactly.positions.push_back(p);
      nearly.positions.push_back(p +
                                 glm::vec3(rounding(random), rounding(random), rounding(random)));
    }
  }
  origins.positions = once.positions;
  origins.positions.insert(origins.positions.end(), 3000, glm::vec3(0.0f));
  EXPECT_EQ(depth_for(exactly, 0.05), depth);
  EXPECT_EQ(depth_for(nearly, 0.05), depth);
  EXPECT_EQ(depth_for(origins, 0.05), depth);
}

TEST(Svo, has_the_same_depth_whatever_the_order_of_its_points) {
  PointCloud cloud = random_shell(300, 6);
  for (std::size_t i = 0; i < 300; ++i) {
    // Many repeat each other in one cell, with equal x, so that only some can be compared.
    cloud.positions.push_back({0.1f, 0.1f + 1e-6f * static_cast<float>(i % 40), 0.1f});
  }
  std::mt19937 random(7);
  const int depth = depth_for(cloud, 0.05);
  for (int order = 0; order < 20; ++order) {
    std::shuffle(cloud.positions.begin(), cloud.positions.end(), random);
    EXPECT_EQ(depth_for(cloud, 0.05), depth);
  }
}

TEST(Svo, survives_points_that_are_no_numbers) {
  PointCloud cloud = random_shell(500, 9);
  const float nan = std::numeric_limits<float>::quiet_NaN();
  for (int i = 0; i < 400; ++i) {
    cloud.positions.push_back({i % 2 ? nan : 0.0f, i % 3 ? nan : 0.0f, i % 5 ? nan : 0.0f});
  }
  EXPECT_TRUE(sort_to_depth(cloud, Cube{glm::dvec3(-1.0), 2.0}, DepthRule{}));
}

TEST(CodingRule, keeps_few_points_within_a_thousandth_of_the_cube) {
  std::mt19937 random(3);
  std::uniform_real_distribution<float> anywhere(0.0f, 1.0f);
  const Cube cube{glm::dvec3(0.0), 1.0};
  for (const std::size_t points : {1u, 2u, 3u, 5u, 20u, 39u, 64u, 200u}) {
    PointCloud cloud;
    for (std::size_t i = 0; i < points; ++i)
      cloud.positions.emplace_back(anywhere(random), anywhere(random), anywhere(random));
    const auto sorted = sort_to_depth(cloud, cube, coding_rule(DepthRule{}, points));
    ASSERT_TRUE(sorted);
    const PointCloud leaves = leaf_centers(build_svo(sorted->sorted, sorted->depth));
    for (const glm::vec3& p : cloud.positions) {
      float nearest = 1.0f;
      for (const glm::vec3& leaf : leaves.positions)
        nearest = std::min(nearest, glm::distance(p, leaf));
      EXPECT_LT(nearest, points <= 64 ? 1e-3f : 2e-3f) << points;
    }
  }
}

TEST(CodingRule, leaves_surfaces_of_many_points_and_fixed_depths_as_they_are) {
  for (const std::size_t points : {4000u, 20000u, 100000u}) {
    const PointCloud cloud = random_shell(points, 2);
    const Cube cube = bounding_cube(bounds(cloud));
    EXPECT_EQ(sort_to_depth(cloud, cube, coding_rule(DepthRule{}, points))->depth,
              sort_to_depth(cloud, cube, DepthRule{})->depth);
  }
  const PointCloud one = cloud_of({{1, 2, 3}});
  EXPECT_EQ(sort_to_depth(one, Cube{}, coding_rule(DepthRule::fixed(4), 1))->depth, 4);
  DepthRule bounded;
  bounded.most = 3;
  EXPECT_EQ(sort_to_depth(one, Cube{}, coding_rule(bounded, 1))->depth, 3);
}

TEST(Svo, continues_through_chains_of_single_children) {
  // A far outlier makes the cube large: the pair shares a cell for many levels.
  const PointCloud cloud = cloud_of({{0, 0, 0}, {1e-4f, 0, 0}, {1, 1, 1}});
  EXPECT_EQ(depth_for(cloud, 0.0), 14);
}

TEST(Svo, is_the_same_from_points_sorted_to_fewer_levels) {
  const PointCloud cloud = random_shell(5000, 8);
  const SortedPoints all = sort_points(cloud, Cube{glm::dvec3(-1.0), 2.0});
  for (const int levels : {0, 1, 9, 14}) {
    const SortedPoints some = sort_points(cloud, Cube{glm::dvec3(-1.0), 2.0}, levels);
    ASSERT_EQ(some.occupied.size(), static_cast<std::size_t>(levels) + 1);
    EXPECT_TRUE(std::equal(some.occupied.begin(), some.occupied.end(), all.occupied.begin()));
    EXPECT_EQ(build_svo(some, levels).masks, build_svo(all, levels).masks);
    EXPECT_EQ(mean_attributes(build_svo(some, levels), cloud, some).colors,
              mean_attributes(build_svo(all, levels), cloud, all).colors);
  }
}

TEST(Svo, divides_as_deep_as_necessary_to_separate_points) {
  // The points separate at level 20 only, deeper than the first sort goes.
  const PointCloud cloud = cloud_of({{0, 0, 0}, {1.5f / (1 << 20), 0, 0}, {1, 1, 1}});
  EXPECT_EQ(depth_for(cloud, 0.0), 20);
  EXPECT_EQ(depth_for(cloud, 0.3), 20);
  EXPECT_EQ(depth_for(cloud, 0.4), 1);
}

TEST(Svo, is_a_line_of_cells_if_only_one_axis_has_extent) {
  PointCloud cloud;
  for (int i = 0; i < 64; ++i) cloud.positions.push_back({2, static_cast<float>(i) / 63, 7});
  const SortedPoints sorted = sort_points(cloud, bounding_cube(bounds(cloud)));
  EXPECT_EQ(sorted.occupied[6], 64u);
  for (const glm::uvec3& cell : leaf_cells(build_svo(sorted, 6))) {
    EXPECT_EQ(cell.x, 0u);
    EXPECT_EQ(cell.z, 0u);
  }
}

TEST(DepthRule, accepts_valid_deltas_and_refuses_others) {
  std::array<std::uint32_t, kMaxDepth + 1> occupied{};
  occupied.fill(8);
  occupied[0] = 1;
  const auto choose = [&](double delta) {
    return choose_depth(occupied, 8, DepthRule::by_delta(delta));
  };
  EXPECT_FALSE(choose(std::numeric_limits<double>::quiet_NaN()));
  EXPECT_FALSE(choose(-0.01));
  EXPECT_EQ(choose(0.0).value(), 1);
  EXPECT_EQ(choose(1.0).value(), 0);
  EXPECT_EQ(choose(std::numeric_limits<double>::infinity()).value(), 0);
  EXPECT_FALSE(choose_depth(occupied, 8, DepthRule::fixed(22)));
  EXPECT_FALSE(choose_depth(occupied, 8, DepthRule::fixed(-1)));
  EXPECT_EQ(choose_depth(occupied, 8, DepthRule::fixed(21)).value(), 21);
}

TEST(DepthRule, never_exceeds_its_greatest_depth) {
  const PointCloud cloud = random_shell(5000, 8);
  const Cube cube = bounding_cube(bounds(cloud));
  for (DepthRule rule :
       {DepthRule::by_delta(0.0), DepthRule::by_delta(0.05), DepthRule::fixed(13)}) {
    const int free = sort_to_depth(cloud, cube, rule)->depth;
    for (const int most : {0, 3, free - 1, free, kMaxDepth}) {
      rule.most = most;
      const auto sorted = sort_to_depth(cloud, cube, rule);
      EXPECT_EQ(sorted->depth, std::min(free, most));
      EXPECT_GE(sorted->sorted.levels, sorted->depth);
    }
    rule.most = -1;
    EXPECT_FALSE(sort_to_depth(cloud, cube, rule));
    rule.most = kMaxDepth + 1;
    EXPECT_FALSE(sort_to_depth(cloud, cube, rule));
  }
}

TEST(Svo, equals_a_shallower_build_when_truncated) {
  const SortedPoints sorted = sort_points(random_shell(5000, 4), Cube{glm::dvec3(-1.0), 2.0});
  const Svo deep = build_svo(sorted, 9);
  for (int depth = 0; depth <= 9; ++depth) {
    const Svo cut = truncate(deep, depth), built = build_svo(sorted, depth);
    EXPECT_EQ(cut.masks, built.masks);
    EXPECT_EQ(cut.first_child, built.first_child);
    EXPECT_EQ(cut.level_begin, built.level_begin);
  }
}

TEST(Svo, cannot_be_indexed_from_masks_that_form_no_tree) {
  const auto indexes = [](int depth, std::vector<std::uint8_t> masks) {
    Svo svo;
    svo.depth = depth;
    svo.masks = std::move(masks);
    return index_svo(svo, true);
  };
  EXPECT_TRUE(indexes(0, {}));
  EXPECT_TRUE(indexes(2, {0b11, 1, 0b10}));
  EXPECT_FALSE(indexes(2, {0b11, 1}));        // too few masks
  EXPECT_FALSE(indexes(2, {0b11, 1, 1, 1}));  // too many masks
  EXPECT_FALSE(indexes(2, {0b11, 0, 1}));     // an internal node without children
  EXPECT_FALSE(indexes(1, {}));               // a root without children
  EXPECT_FALSE(indexes(0, {1}));              // a single cell with children
}

TEST(NodeAttributes, are_means_of_points_in_leaves_and_of_leaves_above) {
  PointCloud cloud = cloud_of({{0.1f, 0.1f, 0.1f}, {0.2f, 0.1f, 0.1f}, {0.9f, 0.9f, 0.9f}});
  cloud.colors = {{0, 10, 100}, {10, 20, 100}, {65535, 0, 0}};
  cloud.normals = {{1, 0, 0}, {0, 1, 0}, {0, 0, 0}};
  const SortedPoints sorted = sort_points(cloud, Cube{});
  const Svo svo = build_svo(sorted, 1);
  const NodeAttributes attributes = mean_attributes(svo, cloud, sorted);
  ASSERT_EQ(attributes.colors.size(), 3u);
  EXPECT_EQ(attributes.colors[1], glm::u16vec3(5, 15, 100));
  EXPECT_EQ(attributes.colors[2], glm::u16vec3(65535, 0, 0));
  EXPECT_EQ(attributes.colors[0], glm::u16vec3(32770, 8, 50));
  EXPECT_EQ(attributes.normals[1], glm::i16vec3(23170, 23170, 0));
  EXPECT_EQ(attributes.normals[2], glm::i16vec3(0));
}

TEST(NodeAttributes, do_not_depend_on_the_order_of_the_points) {
  PointCloud cloud = random_shell(4000, 5), reversed = cloud;
  std::reverse(reversed.positions.begin(), reversed.positions.end());
  std::reverse(reversed.normals.begin(), reversed.normals.end());
  std::reverse(reversed.colors.begin(), reversed.colors.end());
  const SortedPoints a = sort_points(cloud, Cube{glm::dvec3(-1.0), 2.0});
  const SortedPoints b = sort_points(reversed, Cube{glm::dvec3(-1.0), 2.0});
  const Svo svo = build_svo(a, 4);
  const NodeAttributes x = mean_attributes(svo, cloud, a), y = mean_attributes(svo, reversed, b);
  EXPECT_EQ(x.colors, y.colors);
  EXPECT_EQ(x.normals, y.normals);
}

TEST(NodeAttributes, agree_with_those_of_sorted_points_if_each_leaf_has_one) {
  PointCloud cloud = random_shell(500, 6);
  const SortedPoints sorted = sort_points(cloud, Cube{glm::dvec3(-1.0), 2.0});
  const Svo svo = build_svo(sorted, kMaxDepth);
  ASSERT_EQ(svo.leaf_count(), cloud.size());
  PointCloud leaves;
  for (const KeyIndex& p : sorted.points) {
    leaves.positions.push_back(cloud.positions[p.index]);
    leaves.colors.push_back(cloud.colors[p.index]);
    leaves.normals.push_back(cloud.normals[p.index]);
  }
  const NodeAttributes a = mean_attributes(svo, cloud, sorted), b = mean_attributes(svo, leaves);
  EXPECT_EQ(a.colors, b.colors);
  EXPECT_EQ(a.normals, b.normals);
}

/// Turns about half of the normals around.
PointCloud with_random_signs(PointCloud cloud, unsigned seed) {
  std::mt19937 random(seed);
  for (glm::vec3& n : cloud.normals)
    if (random() % 2 == 0) n = -n;
  return cloud;
}

TEST(MeanNormalLines, are_the_same_but_for_their_signs_whatever_the_signs_of_the_normals) {
  const PointCloud cloud = random_shell(4000, 7);
  const SortedPoints sorted = sort_points(cloud, Cube{glm::dvec3(-1.0), 2.0});
  const Svo svo = build_svo(sorted, 5);
  const std::vector<glm::i16vec3> means = mean_normal_lines(svo, cloud, sorted);
  ASSERT_EQ(means.size(), svo.node_count());
  for (unsigned seed = 0; seed < 10; ++seed) {
    const auto turned = mean_normal_lines(svo, with_random_signs(cloud, seed), sorted);
    for (std::size_t i = 0; i < means.size(); ++i)
      EXPECT_TRUE(turned[i] == means[i] || turned[i] == -means[i]) << seed << ", node " << i;
  }
}

TEST(MeanNormalLines, are_the_mean_normals_where_those_agree) {
  const PointCloud cloud = random_shell(4000, 8);
  const SortedPoints sorted = sort_points(cloud, Cube{glm::dvec3(-1.0), 2.0});
  const Svo svo = build_svo(sorted, 6);
  const auto lines = mean_normal_lines(svo, cloud, sorted),
             means = mean_normals(svo, cloud, sorted);
  // Below the fourth level a cell holds a small part of the sphere.
  for (std::size_t i = svo.level_begin[4]; i < means.size(); ++i)
    EXPECT_GT(glm::dot(glm::vec3(lines[i]), glm::vec3(means[i])), 0.99f * 32767.0f * 32767.0f);
}

TEST(MeanNormalLines, are_zero_only_where_all_normals_are) {
  PointCloud cloud = cloud_of({{0.1f, 0.1f, 0.1f}, {0.2f, 0.1f, 0.1f}, {0.9f, 0.9f, 0.9f}});
  cloud.normals = {{0, 0, 1}, {0, 0, -1}, {0, 0, 0}};
  const SortedPoints sorted = sort_points(cloud, Cube{});
  const auto means = mean_normal_lines(build_svo(sorted, 1), cloud, sorted);
  ASSERT_EQ(means.size(), 3u);
  EXPECT_EQ(std::abs(means[0].z), 32767);
  EXPECT_EQ(std::abs(means[1].z), 32767);
  EXPECT_EQ(means[2], glm::i16vec3(0));
}

/// Expects what is built of a cloud with any number of threads to be what is built with one.
void expect_same_with_threads(const PointCloud& cloud, int depth, const char* what) {
  const Cube cube{glm::dvec3(-1.0), 2.0};
  const auto bytes_equal = [](const auto& a, const auto& b) { return std::ranges::equal(a, b); };
  for (const int levels : {depth, kMaxDepth}) {
    const SortedPoints sorted = sort_points(cloud, cube, levels);
    const Svo svo = build_svo(sorted, depth);
    const NodeAttributes attributes = mean_attributes(svo, cloud, sorted);
    const auto lines = mean_normal_lines(svo, cloud, sorted);
    for (const Executor& executor : some_executors()) {
      const SortedPoints sorted2 = sort_points(cloud, cube, levels, executor);
      ASSERT_EQ(sorted2.occupied, sorted.occupied) << what;
      ASSERT_TRUE(std::ranges::equal(sorted2.points, sorted.points,
                                     [](const KeyIndex& a, const KeyIndex& b) {
                                       return a.key == b.key && a.index == b.index;
                                     }))
          << what;
      const Svo svo2 = build_svo(sorted, depth, executor);
      ASSERT_EQ(svo2.level_begin, svo.level_begin) << what;
      ASSERT_EQ(svo2.masks, svo.masks) << what;
      ASSERT_EQ(svo2.first_child, svo.first_child) << what;
      const NodeAttributes attributes2 = mean_attributes(svo, cloud, sorted, executor);
      ASSERT_TRUE(bytes_equal(attributes2.colors, attributes.colors)) << what;
      ASSERT_TRUE(bytes_equal(attributes2.normals, attributes.normals)) << what;
      ASSERT_TRUE(bytes_equal(mean_normal_lines(svo, cloud, sorted, executor), lines)) << what;
    }
  }
  const auto rule = DepthRule::by_delta(0.05);
  const int by_delta = sort_to_depth(cloud, cube, rule)->depth;
  for (const Executor& executor : some_executors())
    ASSERT_EQ(sort_to_depth(cloud, cube, rule, executor)->depth, by_delta) << what;
}

TEST(Svo, is_the_same_for_any_number_of_threads) {
  const PointCloud cloud = random_shell(110'000, 10);
  expect_same_with_threads(cloud, 9, "a shell");
  expect_same_with_threads(cloud, 3, "a shell with hundreds of points in each leaf");
  expect_same_with_threads(cloud, 0, "a single leaf");
  expect_same_with_threads(random_shell(70'000, 11), kMaxDepth, "a shell to the last level");
  expect_same_with_threads(PointCloud{}, 5, "no points");
  expect_same_with_threads(random_shell(1, 12), 5, "a point");
}

TEST(Svo, is_the_same_for_any_number_of_threads_wherever_their_blocks_meet) {
  PointCloud same = random_shell(1, 13);
  same.positions.resize(100'000, same.positions[0]);
  same.normals.resize(100'000, same.normals[0]);
  same.colors.resize(100'000, same.colors[0]);
  expect_same_with_threads(same, 8, "identical points");
  // With few points around many that share one leaf, blocks meet inside, before and behind them.
  for (const std::size_t before : {0u, 1u, 20'000u, 49'999u, 50'000u}) {
    PointCloud cloud = same;
    for (std::size_t i = 0; i < before; ++i) {
      const auto t = static_cast<float>(i) / 50'000.0f;
      cloud.positions[i] = {-0.9f, -0.9f + 1.5f * t, 0.3f * t * t};
    }
    expect_same_with_threads(cloud, 10, "repeated points among others");
  }
  // Chains of single children, whose nodes all blocks share down to the last levels.
  PointCloud near = random_shell(100'000, 14);
  for (std::size_t i = 0; i < near.size(); ++i) near.positions[i] *= i % 1000 == 0 ? 1e-3f : 1e-5f;
  expect_same_with_threads(near, kMaxDepth, "a small part of the cube");
}

}  // namespace
}  // namespace pointreel::svo_test
