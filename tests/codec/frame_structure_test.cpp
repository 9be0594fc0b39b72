#include "codec/octree/frame_structure.h"

#include <bit>
#include <map>
#include <random>

#include <gtest/gtest.h>

#include "codec/core/build.h"
#include "codec/core/morton.h"

namespace pointreel::frame_structure_test {
namespace {

Svo random_tree(std::size_t points, int depth, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> anywhere(0.2f, 0.9f);
  PointCloud cloud;
  for (std::size_t i = 0; i < points; ++i) {
    // Half of them lie in a plane.
    cloud.positions.emplace_back(anywhere(random), anywhere(random),
                                 i % 2 == 0 ? 0.5f : anywhere(random));
  }
  return build_svo(sort_points(cloud, Cube{}), depth);
}

TEST(FrameStructure, orders_nodes_by_z_and_places_them_in_planes) {
  for (const int depth : {1, 2, 5, 8, 9}) {
    const Svo svo = random_tree(3000, depth, 1);
    const FrameStructure structure(svo, {depth});
    for (int level = 1; level < depth; ++level) {
      const LevelStructure& of = structure.level(level);
      if (!of.predictable) continue;
      const std::vector<glm::uvec3> cells = leaf_cells(truncate(svo, level));
      const std::uint32_t begin = svo.level_begin[static_cast<std::size_t>(level)];
      ASSERT_EQ(of.by_z.nodes.size(), cells.size());
      glm::uvec2 least(~0u);
      for (const glm::uvec3& cell : cells) least = glm::min(least, glm::uvec2(cell));
      std::size_t branching = 0;
      std::uint32_t last_z = 0, last_node = 0;
      for (std::size_t s = 0; s + 1 < of.by_z.slices.size(); ++s) {
        const auto& slice = of.by_z.slices[s];
        ASSERT_EQ(slice.branching_begin, branching);
        ASSERT_LT(slice.begin, of.by_z.slices[s + 1].begin);
        for (std::uint32_t i = slice.begin; i < of.by_z.slices[s + 1].begin; ++i) {
          const std::uint32_t node = of.by_z.nodes[i];
          const glm::uvec3 cell = cells[node - begin];
          ASSERT_EQ(cell.z, slice.z);
          if (i > 0) {
            ASSERT_TRUE(cell.z > last_z || node > last_node);
          }
          last_z = cell.z;
          last_node = node;
          const glm::uvec2 at = glm::uvec2(cell) - least + 1u;
          const std::uint32_t place = of.place(of.by_z.at[i]);
          ASSERT_EQ(place, at.y * of.stride + at.x);
          ASSERT_LT(place + of.stride + 1, of.plane);
          if (std::has_single_bit(svo.masks[node])) continue;
          const BranchingNode& found = of.by_z.branching[branching++];
          ASSERT_EQ(found.number, node);
          ASSERT_EQ(found.place, place);
          ASSERT_EQ(found.mask, svo.masks[node]);
          ASSERT_EQ(found.first_child, svo.first_child[node]);
        }
      }
      ASSERT_EQ(branching, of.branching.size());
    }
  }
}

TEST(FrameStructure, counts_the_descendants_of_a_node_at_the_end_of_its_layer) {
  const Svo svo = random_tree(2000, 9, 2);
  const FrameStructure structure(svo, {4, 7, 9});
  for (int level = 0; level < 9; ++level) {
    const int end = level < 4 ? 4 : level < 7 ? 7 : 9;
    EXPECT_EQ(structure.has_unit_children(level), level + 1 == end);
    std::map<std::uint64_t, std::uint32_t> counts;
    for (const glm::uvec3& cell : leaf_cells(truncate(svo, end))) {
      ++counts[morton_encode(cell >> static_cast<unsigned>(end - level))];
    }
    std::uint32_t node = svo.level_begin[static_cast<std::size_t>(level)];
    for (const auto& [key, count] : counts) ASSERT_EQ(structure.weights()[node++], count);
  }
}

TEST(FrameStructure, takes_little_memory_for_few_points_far_apart) {
  PointCloud cloud;
  cloud.positions = {glm::vec3(0.01f), glm::vec3(0.99f)};
  const Svo svo = build_svo(sort_points(cloud, Cube{}), kMaxDepth);
  const FrameStructure structure(svo, {7, 9, kMaxDepth});
  EXPECT_TRUE(structure.level(8).predictable);
  EXPECT_FALSE(structure.level(9).predictable);
  EXPECT_FALSE(structure.level(20).predictable);
  EXPECT_LE(structure.largest_plane(), 65536u);
}

TEST(FrameStructure, of_a_tree_without_inner_nodes_is_empty) {
  Svo empty;
  EXPECT_EQ(FrameStructure(empty, {0}).largest_plane(), 0u);
  const Svo cell = random_tree(1, 0, 3);
  EXPECT_EQ(FrameStructure(cell, {0}).largest_plane(), 0u);
}

}  // namespace
}  // namespace pointreel::frame_structure_test
