#include "client/scene/gap_filling.h"

#include <algorithm>
#include <random>
#include <set>
#include <tuple>

#include <gtest/gtest.h>

#include "tests/tree_of_cells.h"

namespace pointreel::gap_filling_test {
namespace {

using CellSet = std::set<std::tuple<int, int, int>>;

CellSet set_of(const std::vector<glm::uvec3>& cells) {
  CellSet set;
  for (const glm::uvec3& cell : cells) set.insert({cell.x, cell.y, cell.z});
  return set;
}

/// The cells to be filled, found cell by cell: those between two others along a line, and one of
/// those nearest to the middle of two that have no cell exactly between them.
CellSet slowly_filled(const std::vector<glm::uvec3>& cells, int depth, int widest) {
  const CellSet there = set_of(cells);
  CellSet filled;
  const int edge = 1 << depth;
  const auto occupied = [&there](const glm::ivec3& at) {
    return there.contains({at.x, at.y, at.z});
  };
  const auto distance = [&occupied, widest](glm::ivec3 at, glm::ivec3 line) {
    for (int i = 1; i <= widest; ++i) {
      at += line;
      if (occupied(at)) return i;
    }
    return widest + 1;
  };
  for (int i = 0; i < edge * edge * edge; ++i) {
    const glm::ivec3 at(i % edge, i / edge % edge, i / edge / edge);
    if (occupied(at)) continue;
    for (int n = 14; n < 27; ++n) {
      const glm::ivec3 line(n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1);
      if (distance(at, line) + distance(at, -line) > widest + 1) continue;
      filled.insert({at.x, at.y, at.z});
      break;
    }
  }
  for (const glm::uvec3& cell : cells) {
    const glm::ivec3 from(cell);
    for (int n = 0; n < 125; ++n) {
      const glm::ivec3 step(n % 5 - 2, n / 5 % 5 - 2, n / 25 - 2);
      if (glm::all(glm::lessThan(glm::abs(step), glm::ivec3(2))) || !occupied(from + step))
        continue;
      const glm::ivec3 first(glm::floor(0.5f * glm::vec3(step)));
      const glm::ivec3 last(glm::ceil(0.5f * glm::vec3(step)));
      bool any = false;
      for (int z = first.z; z <= last.z; ++z) {
        for (int y = first.y; y <= last.y; ++y) {
          for (int x = first.x; x <= last.x; ++x) any = any || occupied(from + glm::ivec3(x, y, z));
        }
      }
      const glm::ivec3 at = from + first;
      if (!any) filled.insert({at.x, at.y, at.z});
    }
  }
  return filled;
}

std::vector<glm::uvec3> random_cells(unsigned seed, int depth, std::size_t count) {
  std::mt19937 random(seed);
  const unsigned edge = 1u << depth;
  std::vector<glm::uvec3> cells;
  for (std::size_t i = 0; i < count; ++i)
    cells.emplace_back(random() % edge, random() % edge, random() % edge);
  return cells;
}

/// The cells of the original leaves and of the new ones.
struct Leaves {
  CellSet before, filled;
};
Leaves leaves_of(const Svo& svo, const FilledNodes& filled) {
  Leaves leaves;
  const std::vector<glm::uvec3> cells = leaf_cells(svo);
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const bool is_new = !filled.empty() && filled[svo.internal_count() + i];
    (is_new ? leaves.filled : leaves.before).insert({cells[i].x, cells[i].y, cells[i].z});
  }
  return leaves;
}

TEST(GapFilling, fills_gaps_between_two_leaves_in_any_of_13_directions) {
  for (const int depth : {2, 3, 4}) {
    for (const int widest : {1, 2, 3}) {
      const auto cells = random_cells(static_cast<unsigned>(depth + widest), depth,
                                      depth == 2   ? 6
                                      : depth == 3 ? 25
                                                   : 300);
      Svo svo = tree_of_cells(cells, depth);
      NodeAttributes nothing;
      const FilledNodes filled = fill_gaps(svo, nothing, widest);
      const Leaves leaves = leaves_of(svo, filled);
      EXPECT_EQ(leaves.before, set_of(cells));
      EXPECT_EQ(leaves.filled, slowly_filled(cells, depth, widest)) << depth << ", " << widest;
      EXPECT_FALSE(leaves.filled.empty());
    }
  }
}

TEST(GapFilling, gives_the_same_tree_as_one_built_from_its_leaves) {
  bool new_bricks = false;
  for (const std::size_t count : {20u, 30u, 40u, 100u, 300u}) {
    auto cells = random_cells(1, 4, count);
    for (glm::uvec3& cell : cells) cell += 16u;  // the root has only its last child
    Svo svo = tree_of_cells(cells, 5);
    const Svo before = svo;
    NodeAttributes nothing;
    const FilledNodes filled = fill_gaps(svo, nothing, 3);
    const Svo again = tree_of_cells(leaf_cells(svo), 5);
    EXPECT_EQ(svo.masks, again.masks);
    EXPECT_EQ(svo.level_begin, again.level_begin);
    EXPECT_EQ(svo.first_child, again.first_child);
    ASSERT_EQ(filled.size(), svo.node_count());
    for (int level = 0; level <= 5; ++level) {
      const auto begin = filled.begin() + svo.level_begin[static_cast<std::size_t>(level)];
      EXPECT_EQ(std::count(begin, begin + svo.node_count(level), false), before.node_count(level))
          << level;
    }
    new_bricks = new_bricks || svo.node_count(3) > before.node_count(3);
  }
  EXPECT_TRUE(new_bricks) << "new nodes above those just above the leaves";
}

TEST(GapFilling, colours_new_leaves_like_the_leaves_that_touch_them) {
  // A gap of three cells along x. No original leaf touches the middle one.
  const std::vector<glm::uvec3> cells = {{0, 0, 0}, {4, 0, 0}};
  Svo svo = tree_of_cells(cells, 3);
  NodeAttributes attributes;
  attributes.colors.resize(svo.node_count());
  attributes.normals.assign(svo.node_count(), {32767, 0, 0});
  attributes.colors[svo.internal_count()] = {100, 0, 65535};
  attributes.colors[svo.internal_count() + 1] = {300, 0, 65535};
  const FilledNodes filled = fill_gaps(svo, attributes, 3);
  ASSERT_EQ(svo.leaf_count(), 5u);
  ASSERT_EQ(attributes.colors.size(), svo.node_count());
  ASSERT_EQ(attributes.normals.size(), svo.node_count());
  const std::vector<glm::uvec3> leaves = leaf_cells(svo);
  for (std::size_t i = 0; i < leaves.size(); ++i) {
    const unsigned red = std::array{100u, 100u, 200u, 300u, 300u}[leaves[i].x];
    EXPECT_EQ(attributes.colors[svo.internal_count() + i], glm::u16vec3(red, 0, 65535));
    EXPECT_EQ(attributes.normals[svo.internal_count() + i], glm::i16vec3(32767, 0, 0));
    EXPECT_EQ(filled[svo.internal_count() + i], leaves[i].x % 4 != 0);
  }
  // The node above cells 2 and 3 is new too. The others keep their attributes.
  const std::uint32_t parent = svo.level_begin[2];
  ASSERT_EQ(svo.node_count(2), 3u);
  EXPECT_TRUE(filled[parent + 1]);
  EXPECT_EQ(attributes.colors[parent + 1], glm::u16vec3(250, 0, 65535));
  EXPECT_FALSE(filled[parent]);
  EXPECT_EQ(attributes.colors[parent], glm::u16vec3(0));
}

TEST(GapFilling, leaves_closed_surfaces_and_isolated_leaves_unchanged) {
  NodeAttributes nothing;
  Svo none;
  EXPECT_TRUE(fill_gaps(none, nothing, 3).empty());
  EXPECT_EQ(gap_to_fill(none, 0), 0);
  Svo single = tree_of_cells({{5, 6, 7}}, 4);
  EXPECT_TRUE(fill_gaps(single, nothing, 3).empty());
  EXPECT_EQ(single.leaf_count(), 1u);
  // A plane, a net in that plane, and points so far apart that nodes near the leaves hold one.
  std::vector<glm::uvec3> plane, net, apart;
  for (unsigned x = 0; x < 32; ++x) {
    for (unsigned y = 0; y < 32; ++y) {
      plane.emplace_back(x, y, 3);
      if (x % 3 == 0 || y % 3 == 0) net.emplace_back(x, y, 3);
      if (x % 8 == 0 && y % 8 == 0) apart.emplace_back(x, y, 3);
    }
  }
  const auto gap = [](const std::vector<glm::uvec3>& cells, std::size_t points_per_leaf) {
    const auto points = static_cast<std::uint32_t>(cells.size() * points_per_leaf);
    return gap_to_fill(tree_of_cells(cells, 5), points);
  };
  EXPECT_EQ(gap(plane, 3), 0);
  EXPECT_EQ(gap(apart, 1), 0);
  EXPECT_EQ(gap(net, 3), 3);
  EXPECT_EQ(gap(net, 8), 1);
}

TEST(GapFilling, fills_the_cells_that_random_points_miss_on_a_surface_that_looks_closed) {
  // Three random points to a cell of a plane leave a twentieth of the cells empty.
  constexpr std::uint32_t kPoints = 3 * 64 * 64;
  std::mt19937 random(5);
  std::vector<glm::uvec3> cells;
  for (std::uint32_t i = 0; i < kPoints; ++i) cells.emplace_back(random() % 64, random() % 64, 3);
  Svo svo = tree_of_cells(cells, 6);
  const std::uint32_t before = svo.leaf_count();
  EXPECT_LT(before, 3950u);
  const int widest = gap_to_fill(svo, kPoints);
  ASSERT_GT(widest, 0);
  NodeAttributes nothing;
  fill_gaps(svo, nothing, widest);
  EXPECT_GE(svo.leaf_count(), 64u * 64u - 8u) << "of " << before;
  EXPECT_EQ(gap_to_fill(tree_of_cells(cells, 6), before), 0) << "voxelised input is as it is";
}

}  // namespace
}  // namespace pointreel::gap_filling_test
