#include "client/scene/leaf_neighbors.h"

#include <random>
#include <set>
#include <tuple>

#include <gtest/gtest.h>

#include "tests/tree_of_cells.h"

namespace pointreel::leaf_neighbors_test {
namespace {

NeighborBits slow_neighbors(const std::set<std::tuple<int, int, int>>& cells, glm::ivec3 at) {
  NeighborBits bits = 0;
  for (unsigned direction = 0; direction < 6; ++direction) {
    glm::ivec3 beside = at;
    beside[static_cast<int>(direction / 2)] += direction % 2 == 1 ? 1 : -1;
    if (cells.contains({beside.x, beside.y, beside.z}))
      bits = static_cast<NeighborBits>(bits | 1u << direction);
  }
  return bits;
}

TEST(LeafNeighbors, are_those_that_a_search_in_a_set_finds) {
  std::mt19937 random(3);
  for (const int depth : {1, 2, 4, 6}) {
    const unsigned edge = 1u << depth;
    std::vector<glm::uvec3> filled;
    std::set<std::tuple<int, int, int>> cells;
    for (unsigned i = 0; i < edge * edge * edge / 3 + 1 && i < 4000; ++i) {
      const glm::uvec3 cell(random() % edge, random() % edge, random() % edge);
      if (cells.insert({cell.x, cell.y, cell.z}).second) filled.push_back(cell);
    }
    const Svo svo = tree_of_cells(filled, depth);
    const std::vector<NeighborBits> neighbors = leaf_neighbors(svo);
    const std::vector<glm::uvec3> leaves = leaf_cells(svo);
    ASSERT_EQ(neighbors.size(), leaves.size());
    for (std::size_t i = 0; i < leaves.size(); ++i)
      ASSERT_EQ(neighbors[i], slow_neighbors(cells, glm::ivec3(leaves[i]))) << depth;
  }
}

TEST(LeafNeighbors, are_none_for_an_empty_tree_and_for_a_single_cell) {
  EXPECT_TRUE(leaf_neighbors(Svo{}).empty());
  const Svo one = tree_of_cells({{0, 0, 0}}, 0);
  EXPECT_EQ(leaf_neighbors(one), std::vector<NeighborBits>{0});
}

TEST(LeafNeighbors, hide_a_voxel_from_an_octant_if_they_cover_its_three_faces) {
  const NeighborBits all = 0x3f;
  for (unsigned octant = 0; octant < 8; ++octant) {
    EXPECT_TRUE(hidden(all, octant));
    EXPECT_FALSE(hidden(0, octant));
    for (unsigned direction = 0; direction < 6; ++direction) {
      // A face is visible if the neighbour on the eye's side of its axis is missing.
      const auto missing = static_cast<NeighborBits>(all & ~(1u << direction));
      const bool towards_eye = (octant >> direction / 2 & 1u) == direction % 2;
      EXPECT_EQ(hidden(missing, octant), !towards_eye);
    }
  }
}

}  // namespace
}  // namespace pointreel::leaf_neighbors_test
