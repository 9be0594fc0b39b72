#include "codec/surface/leaf_heights.h"

#include <cmath>
#include <random>
#include <set>
#include <tuple>
#include <vector>

#include <gtest/gtest.h>

#include "codec/surface/leaf_pairs.h"
#include "tests/tree_of_cells.h"

namespace pointreel::leaf_heights_test {
namespace {

constexpr int kDepth = 6;
constexpr unsigned kEdge = 1u << kDepth;

using Cells = std::vector<glm::uvec3>;

TEST(LeafPairs, are_those_that_a_search_among_all_finds) {
  std::mt19937 random(5);
  for (const int depth : {1, 2, 3, 5}) {
    const unsigned edge = 1u << depth;
    std::set<std::tuple<unsigned, unsigned, unsigned>> cells;
    for (unsigned i = 0; i < edge * edge * edge / 3 + 1 && i < 1500; ++i)
      cells.insert({random() % edge, random() % edge, random() % edge});
    Cells filled;
    for (const auto& [x, y, z] : cells) filled.emplace_back(x, y, z);
    const Svo svo = tree_of_cells(filled, depth);
    const Cells leaves = leaf_cells(svo);
    std::set<std::tuple<std::uint32_t, std::uint32_t, int>> expected, found;
    for (std::uint32_t i = 0; i < leaves.size(); ++i) {
      for (std::uint32_t j = i + 1; j < leaves.size(); ++j) {
        const glm::ivec3 way = glm::ivec3(leaves[j]) - glm::ivec3(leaves[i]) + 1;
        if (way.x < 0 || way.y < 0 || way.z < 0 || way.x > 2 || way.y > 2 || way.z > 2) continue;
        expected.insert({i, j, way.x + 3 * way.y + 9 * way.z});
      }
    }
    const std::vector<LeafPair> pairs = leaf_pairs(svo);
    for (const LeafPair& pair : pairs) found.insert({pair.first, pair.second, pair.place});
    EXPECT_EQ(found.size(), pairs.size()) << "each once";
    EXPECT_EQ(found, expected) << "depth " << depth;
  }
}

TEST(LeafPairs, are_none_without_neighbours) {
  EXPECT_TRUE(leaf_pairs(Svo{}).empty());
  EXPECT_TRUE(leaf_pairs(tree_of_cells({{0, 0, 0}}, 0)).empty());
  EXPECT_TRUE(leaf_pairs(tree_of_cells({{0, 0, 0}, {2, 0, 0}, {0, 2, 2}}, 2)).empty());
}

/// The leaves that a surface passes through, and its normals there.
struct Sampled {
  Svo svo;
  std::vector<glm::i16vec3> normals;
};

/// `height_of(p)`: above the surface, with |gradient| of about 1; p is in cells.
template <class Height, class Normal>
Sampled sample(const Height& height_of, const Normal& normal_of) {
  Cells cells;
  for (unsigned z = 0; z < kEdge; ++z)
    for (unsigned y = 0; y < kEdge; ++y)
      for (unsigned x = 0; x < kEdge; ++x) {
        const glm::dvec3 center = glm::dvec3(x, y, z) + 0.5;
        const glm::dvec3 n = glm::abs(normal_of(center));
        if (std::abs(height_of(center)) <= 0.5 * (n.x + n.y + n.z)) cells.emplace_back(x, y, z);
      }
  Sampled out{tree_of_cells(cells, kDepth), {}};
  out.svo.cube = {glm::dvec3(0.0), static_cast<double>(kEdge)};  // cells of 1
  for (const glm::uvec3& cell : leaf_cells(out.svo))
    out.normals.push_back(glm::i16vec3(32767.0 * normal_of(glm::dvec3(cell) + 0.5)));
  return out;
}

/// The root mean square height of surfels above the surface, in cells, away from the cube's sides.
template <class Height>
double error(const Sampled& sampled, const std::vector<float>& heights, const Height& height_of) {
  const Cells cells = leaf_cells(sampled.svo);
  double squares = 0.0, count = 0.0;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    if (glm::any(glm::lessThan(cells[i], glm::uvec3(4))) ||
        glm::any(glm::greaterThan(cells[i], glm::uvec3(kEdge - 5))))
      continue;
    const glm::dvec3 place =
        glm::dvec3(cells[i]) + 0.5 + double{heights[i]} / 32767.0 * glm::dvec3(sampled.normals[i]);
    const double above = height_of(place);
    squares += above * above;
    ++count;
  }
  return std::sqrt(squares / count);
}

TEST(LeafHeights, put_surfels_onto_planes_and_spheres) {
  const glm::dvec3 n = glm::normalize(glm::dvec3(0.4, 0.85, 0.3));
  const auto above_plane = [&](const glm::dvec3& p) { return glm::dot(p - 31.7, n); };
  const auto away = [](const glm::dvec3& p) { return glm::normalize(p - 32.0); };
  const auto above_sphere = [](const glm::dvec3& p) { return glm::length(p - 32.0) - 20.3; };
  const Sampled plane = sample(above_plane, [&](const glm::dvec3&) { return n; });
  const Sampled sphere = sample(above_sphere, away);
  const std::vector<float> zero(std::max(plane.normals.size(), sphere.normals.size()), 0.0f);
  const double plane_before = error(plane, zero, above_plane);
  const double sphere_before = error(sphere, zero, above_sphere);
  EXPECT_GT(plane_before, 0.3);
  EXPECT_LT(error(plane, leaf_heights(plane.svo, plane.normals, false), above_plane),
            0.15 * plane_before);
  EXPECT_LT(error(sphere, leaf_heights(sphere.svo, sphere.normals, false), above_sphere),
            0.2 * sphere_before);
}

TEST(LeafHeights, are_the_same_for_normals_of_unknown_signs) {
  const auto away = [](const glm::dvec3& p) { return glm::normalize(p - 32.0); };
  const auto above = [](const glm::dvec3& p) { return glm::length(p - 32.0) - 20.3; };
  Sampled sphere = sample(above, away);
  const std::vector<float> known = leaf_heights(sphere.svo, sphere.normals, false);
  std::mt19937 random(9);
  std::vector<bool> turned;
  for (glm::i16vec3& normal : sphere.normals) {
    turned.push_back(random() % 2 == 0);
    if (turned.back()) normal = -normal;
  }
  const std::vector<float> unknown = leaf_heights(sphere.svo, sphere.normals, true);
  for (std::size_t i = 0; i < known.size(); ++i)
    ASSERT_NEAR(unknown[i], turned[i] ? -known[i] : known[i], 1e-5);
}

TEST(LeafHeights, never_leave_the_cell) {
  std::mt19937 random(2);
  std::normal_distribution<float> gauss;
  Cells cells;
  for (int i = 0; i < 3000; ++i) cells.emplace_back(random() % 16, random() % 16, random() % 16);
  const Svo svo = tree_of_cells(cells, 4);
  std::vector<glm::i16vec3> normals;
  for (std::uint32_t i = 0; i < svo.leaf_count(); ++i)
    normals.push_back(glm::i16vec3(
        32767.0f * glm::normalize(glm::vec3(gauss(random), gauss(random), gauss(random)))));
  const double half = 0.5 * svo.cell_size(4);
  for (const bool lines : {false, true}) {
    const std::vector<float> heights = leaf_heights(svo, normals, lines);
    ASSERT_EQ(heights.size(), normals.size());
    for (std::size_t i = 0; i < heights.size(); ++i) {
      const glm::vec3 n = glm::abs(glm::vec3(normals[i]) / 32767.0f);
      ASSERT_LE(std::abs(heights[i]), 1.00001 * half * (n.x + n.y + n.z));
    }
  }
}

TEST(LeafHeights, keep_the_two_sides_of_a_sheet_apart) {
  // Two layers of cells that touch, with opposite normals.
  Cells cells;
  for (unsigned z = 30; z < 32; ++z)
    for (unsigned y = 0; y < kEdge; ++y)
      for (unsigned x = 0; x < kEdge; ++x) cells.emplace_back(x, y, z);
  const Svo svo = tree_of_cells(cells, kDepth);
  std::vector<glm::i16vec3> normals;
  for (const glm::uvec3& cell : leaf_cells(svo))
    normals.emplace_back(0, 0, cell.z == 30 ? -32767 : 32767);
  for (const float height : leaf_heights(svo, normals, false)) ASSERT_EQ(height, 0.0f);
}

TEST(LeafHeights, are_zero_where_nothing_is_known) {
  const Svo svo = tree_of_cells({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {3, 3, 3}}, 2);
  const std::vector<glm::i16vec3> none(4, glm::i16vec3(0));
  EXPECT_EQ(leaf_heights(svo, none, false), std::vector<float>(4, 0.0f));
  EXPECT_EQ(leaf_heights(svo, none, true), std::vector<float>(4, 0.0f));
  EXPECT_TRUE(leaf_heights(Svo{}, {}, false).empty());
}

}  // namespace
}  // namespace pointreel::leaf_heights_test
