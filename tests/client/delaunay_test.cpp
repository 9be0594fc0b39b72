#include "client/strips/delaunay.h"

#include <algorithm>
#include <random>
#include <set>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

namespace pointreel::delaunay_test {
namespace {

__extension__ typedef __int128 Wide;
using Corners = std::array<std::uint16_t, 3>;

Wide turn(const glm::ivec2& a, const glm::ivec2& b, const glm::ivec2& c) {
  return Wide{b.x - a.x} * (c.y - a.y) - Wide{b.y - a.y} * (c.x - a.x);
}

/// Above 0 if d is within the circle around a triangle that turns to the left: the determinant.
Wide in_circle(const glm::ivec2& a, const glm::ivec2& b, const glm::ivec2& c, const glm::ivec2& d) {
  const auto row = [&d](const glm::ivec2& p) {
    const Wide x = p.x - d.x, y = p.y - d.y;
    return std::array<Wide, 3>{x, y, x * x + y * y};
  };
  const auto [p, q, r] = std::array{row(a), row(b), row(c)};
  return p[0] * (q[1] * r[2] - q[2] * r[1]) - p[1] * (q[0] * r[2] - q[2] * r[0]) +
         p[2] * (q[0] * r[1] - q[1] * r[0]);
}

/// The number of points on the rim of the convex hull, those between its corners included.
std::size_t hull_size(std::vector<glm::ivec2> points) {
  const auto less = [](const glm::ivec2& a, const glm::ivec2& b) {
    return std::pair(a.x, a.y) < std::pair(b.x, b.y);
  };
  std::sort(points.begin(), points.end(), less);
  points.erase(std::unique(points.begin(), points.end()), points.end());
  std::set<std::pair<int, int>> rim;
  for (int side = 0; side < 2; ++side) {
    std::vector<glm::ivec2> chain;
    for (const glm::ivec2& p : points) {
      while (chain.size() > 1 && turn(chain[chain.size() - 2], chain.back(), p) < 0)
        chain.pop_back();
      chain.push_back(p);
    }
    for (const glm::ivec2& p : chain) rim.emplace(p.x, p.y);
    std::reverse(points.begin(), points.end());
  }
  return rim.size();
}

std::size_t distinct(const std::vector<glm::ivec2>& points) {
  std::set<std::pair<int, int>> all;
  for (const glm::ivec2& p : points) all.emplace(p.x, p.y);
  return all.size();
}

void expect_delaunay(const std::vector<glm::ivec2>& points) {
  Delaunay delaunay;
  const auto triangles = delaunay.run(points);
  ASSERT_EQ(triangles.size(), 2 * distinct(points) - 2 - hull_size(points));
  std::set<std::pair<int, int>> edges;
  for (const Delaunay::Triangle& triangle : triangles) {
    const auto [a, b, c] = triangle;
    ASSERT_GT(turn(points[a], points[b], points[c]), 0);
    ASSERT_TRUE(edges.emplace(a, b).second);
    ASSERT_TRUE(edges.emplace(b, c).second);
    ASSERT_TRUE(edges.emplace(c, a).second);
    for (const glm::ivec2& p : points) ASSERT_LE(in_circle(points[a], points[b], points[c], p), 0);
  }
}

std::vector<glm::ivec2> random_points(std::mt19937& random, int count, int reach) {
  std::uniform_int_distribution<int> at(-reach, reach);
  std::vector<glm::ivec2> points;
  for (int i = 0; i < count; ++i) points.emplace_back(at(random), at(random));
  return points;
}

TEST(Delaunay, has_no_point_within_the_circle_around_a_triangle) {
  std::mt19937 random(1);
  for (int i = 0; i < 300; ++i)
    expect_delaunay(random_points(random, 3 + i % 60, Delaunay::kReach));
}

TEST(Delaunay, is_exact_where_many_points_coincide_or_lie_on_lines_and_circles) {
  std::mt19937 random(2);
  for (int i = 0; i < 300; ++i) expect_delaunay(random_points(random, 4 + i % 60, 1 + i % 5));
}

TEST(Delaunay, is_exact_at_the_largest_coordinates) {
  constexpr int kMost = Delaunay::kReach;
  expect_delaunay({{-kMost, -kMost}, {kMost, -kMost}, {kMost, kMost}, {-kMost, kMost}, {0, 1}});
  expect_delaunay({{-kMost, -kMost}, {kMost, kMost}, {kMost - 1, kMost}, {-kMost, 1 - kMost}});
}

TEST(Delaunay, of_points_on_a_line_is_empty) {
  Delaunay delaunay;
  EXPECT_TRUE(delaunay.run({}).empty());
  EXPECT_TRUE(delaunay.run(std::vector<glm::ivec2>{{1, 1}}).empty());
  EXPECT_TRUE(delaunay.run(std::vector<glm::ivec2>{{1, 1}, {1, 1}, {1, 1}}).empty());
  EXPECT_TRUE(delaunay.run(std::vector<glm::ivec2>{{0, 0}, {4, 2}, {2, 1}, {-2, -1}}).empty());
}

TEST(Delaunay, takes_the_first_of_points_that_coincide) {
  Delaunay delaunay;
  const auto triangles =
      delaunay.run(std::vector<glm::ivec2>{{0, 0}, {9, 0}, {9, 0}, {0, 9}, {0, 0}});
  ASSERT_EQ(triangles.size(), 1u);
  Corners corners = triangles[0];
  std::sort(corners.begin(), corners.end());
  EXPECT_EQ(corners, (Corners{0, 1, 3}));
}

TEST(Delaunay, of_a_grid_has_diagonals_from_the_lowest_index_whatever_else_is_there) {
  // The points of a grid in a random order, and the same with others beside them.
  std::mt19937 random(3);
  std::vector<glm::ivec2> grid;
  for (int y = 0; y < 6; ++y)
    for (int x = 0; x < 6; ++x) grid.emplace_back(10 * x, 10 * y);
  std::shuffle(grid.begin(), grid.end(), random);
  Delaunay delaunay;
  const auto inner = [&](const std::vector<glm::ivec2>& points) {
    std::set<Corners> all;
    for (const Delaunay::Triangle& triangle : delaunay.run(points)) {
      Corners corners = triangle;
      std::sort(corners.begin(), corners.end());
      if (corners[2] < grid.size()) all.insert(corners);
    }
    return all;
  };
  const std::set<Corners> alone = inner(grid);
  EXPECT_EQ(alone.size(), 50u);
  for (const Corners& corners : alone) {
    // The fourth corner of the square.
    glm::ivec2 low(1000), high(-1000);
    for (const std::uint16_t i : corners) {
      low = glm::min(low, grid[i]);
      high = glm::max(high, grid[i]);
    }
    std::uint16_t lowest = 0xffff;
    for (std::uint16_t i = 0; i < grid.size(); ++i)
      if (glm::all(glm::greaterThanEqual(grid[i], low)) &&
          glm::all(glm::lessThanEqual(grid[i], high)))
        lowest = std::min(lowest, i);
    EXPECT_EQ(corners[0], lowest);
  }
  std::vector<glm::ivec2> more = grid;
  more.insert(more.end(), {{-33, 17}, {90, 71}, {20, -50}, {31, 99}});
  EXPECT_EQ(inner(more), alone);
}

}  // namespace
}  // namespace pointreel::delaunay_test
