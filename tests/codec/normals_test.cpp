#include "codec/surface/normals.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "codec/core/build.h"
#include "codec/surface/cell_neighbors.h"
#include "codec/surface/openness.h"
#include "pointreel/octree.h"

namespace pointreel::normals_test {
namespace {

constexpr double kTau = 2.0 * std::numbers::pi;

/// Points on a surface whose normals are known.
struct Surface {
  PointCloud cloud;
  std::vector<glm::dvec3> normals;

  void add(const glm::dvec3& p, const glm::dvec3& n) {
    cloud.positions.emplace_back(p);
    normals.push_back(n);
  }
};

Surface sphere(std::size_t n) {
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  Surface surface;
  while (surface.normals.size() < n) {
    const glm::dvec3 p = glm::normalize(glm::dvec3(normal(random), normal(random), normal(random)));
    surface.add(p, p);
  }
  return surface;
}

/// A torus with radii 1 and 0.3 around the y axis, with points uniform by area.
Surface torus(std::size_t n) {
  std::mt19937 random(2);
  std::uniform_real_distribution<double> uniform;
  Surface surface;
  while (surface.normals.size() < n) {
    const double a = uniform(random) * kTau, b = uniform(random) * kTau;
    if (uniform(random) * 1.3 > 1.0 + 0.3 * std::cos(b)) continue;
    const glm::dvec3 out(std::cos(a), 0.0, std::sin(a));
    const glm::dvec3 normal = out * std::cos(b) + glm::dvec3(0.0, std::sin(b), 0.0);
    surface.add(out + 0.3 * normal, normal);
  }
  return surface;
}

struct Quality {
  double median_degrees, p95_degrees;  ///< between the lines of the normals, whatever their sign
  double outward;                      ///< share of normals with the right sign
};

Quality compare(const Surface& surface) {
  std::vector<double> angles;
  double outward = 0.0;
  for (std::size_t i = 0; i < surface.normals.size(); ++i) {
    const double d = glm::dot(glm::dvec3(surface.cloud.normals[i]), surface.normals[i]);
    angles.push_back(std::acos(std::min(1.0, std::abs(d))) * 360.0 / kTau);
    outward += d > 0.0 ? 1.0 : 0.0;
  }
  std::sort(angles.begin(), angles.end());
  return {angles[angles.size() / 2], angles[angles.size() * 95 / 100],
          outward / static_cast<double>(angles.size())};
}

TEST(Normals, are_within_a_degree_and_point_outward_on_a_sphere) {
  Surface surface = sphere(20000);
  estimate_normals(surface.cloud);
  const Quality quality = compare(surface);
  EXPECT_LT(quality.median_degrees, 0.6);
  EXPECT_LT(quality.p95_degrees, 1.5);
  EXPECT_EQ(quality.outward, 1.0);
}

TEST(Normals, are_within_a_degree_and_point_outward_on_a_torus) {
  Surface surface = torus(30000);
  estimate_normals(surface.cloud);
  const Quality quality = compare(surface);
  EXPECT_LT(quality.median_degrees, 1.0);
  EXPECT_LT(quality.p95_degrees, 3.0);
  EXPECT_EQ(quality.outward, 1.0);
}

TEST(Normals, point_outward_on_a_body_with_a_hole) {
  Surface whole = sphere(20000), open;
  for (std::size_t i = 0; i < whole.normals.size(); ++i) {
    if (whole.normals[i].y > -0.8) open.add(whole.normals[i], whole.normals[i]);
  }
  estimate_normals(open.cloud);
  EXPECT_GT(compare(open).outward, 0.999);
}

TEST(Normals, stay_close_on_noisy_points) {
  Surface surface = sphere(20000);
  std::mt19937 random(5);
  // The noise is half the spacing of the points.
  std::normal_distribution<float> noise(0.0f, 0.0125f);
  for (glm::vec3& p : surface.cloud.positions) p *= 1.0f + noise(random);
  estimate_normals(surface.cloud);
  const Quality quality = compare(surface);
  EXPECT_LT(quality.median_degrees, 8.0);
  EXPECT_GT(quality.outward, 0.999);
}

TEST(Normals, stay_close_on_a_voxel_grid) {
  Surface surface = sphere(20000);
  for (glm::vec3& p : surface.cloud.positions) p = glm::round(p * 64.0f) / 64.0f;
  estimate_normals(surface.cloud);
  const Quality quality = compare(surface);
  EXPECT_LT(quality.median_degrees, 4.0);
  EXPECT_EQ(quality.outward, 1.0);
}

TEST(Normals, are_exact_on_a_plane) {
  Surface surface;
  for (int x = 0; x < 100; ++x) {
    for (int y = 0; y < 60; ++y) {
      surface.add(glm::dvec3(x, 0.5 * x, y), glm::normalize(glm::dvec3(-0.5, 1, 0)));
    }
  }
  estimate_normals(surface.cloud);
  EXPECT_LT(compare(surface).p95_degrees, 0.01);
}

TEST(Normals, do_not_depend_on_the_order_of_the_points_or_their_origin) {
  Surface surface = torus(5000);
  PointCloud reversed = surface.cloud;
  std::reverse(reversed.positions.begin(), reversed.positions.end());
  estimate_normals_and_radii(surface.cloud);
  estimate_normals_and_radii(reversed);
  std::reverse(reversed.normals.begin(), reversed.normals.end());
  std::reverse(reversed.radii.begin(), reversed.radii.end());
  for (std::size_t i = 0; i < reversed.size(); ++i) {
    EXPECT_LT(glm::length(reversed.normals[i] - surface.cloud.normals[i]), 1e-4f);
    EXPECT_NEAR(reversed.radii[i], surface.cloud.radii[i], 1e-6f);
  }
  PointCloud far = surface.cloud;
  far.origin = {1048576.0, -2097152.0, 0.0};
  estimate_normals(far);
  for (std::size_t i = 0; i < far.size(); ++i) {
    EXPECT_LT(glm::length(far.normals[i] - surface.cloud.normals[i]), 1e-3f);
  }
}

TEST(Radii, equal_the_edge_of_a_square_that_holds_one_point) {
  Surface surface = sphere(20000);
  estimate_normals_and_radii(surface.cloud);
  std::vector<float> radii = surface.cloud.radii;
  std::sort(radii.begin(), radii.end());
  const double expected = std::sqrt(2.0 * kTau / 20000.0);
  EXPECT_NEAR(radii[radii.size() / 2], expected, 0.15 * expected);
  EXPECT_GT(radii.front(), 0.3 * expected);
  EXPECT_LT(radii.back(), 3.0 * expected);
}

TEST(Radii, are_estimated_if_unknown_and_kept_otherwise) {
  PointCloud cloud = sphere(20000).cloud;
  PointCloud estimated = cloud;
  estimate_normals_and_radii(estimated);
  cloud.radii.assign(cloud.size(), 0.02f);
  cloud.radii[7] = 0.0f;
  cloud.radii[11] = 1.0f;
  estimate_unknown_radii(cloud);
  EXPECT_EQ(cloud.radii[7], estimated.radii[7]);
  EXPECT_EQ(cloud.radii[8], 0.02f);
  EXPECT_EQ(cloud.radii[11], 1.0f);
  cloud.radii.assign(cloud.size(), 1e-3f);  // below the spacing: no estimate exceeds given radii
  cloud.radii[7] = 0.0f;
  estimate_unknown_radii(cloud);
  EXPECT_EQ(cloud.radii[7], 1e-3f);
  cloud.radii.clear();
  estimate_unknown_radii(cloud);
  EXPECT_FALSE(cloud.has_radii());
}

TEST(Radii, follow_the_local_spacing) {
  // The right half of a plane has a sixteenth of the points of the left half. A line lies beside
  // it.
  PointCloud cloud;
  for (int x = 0; x < 128; ++x) {
    for (int y = 0; y < 128; ++y) {
      if (x < 64 || (x % 4 == 0 && y % 4 == 0)) cloud.positions.emplace_back(x, y, 0);
    }
  }
  estimate_normals_and_radii(cloud);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const glm::vec3 p = cloud.positions[i];
    if (p.x < 50) {
      EXPECT_NEAR(cloud.radii[i], 1.0f, 0.35f);
    } else if (p.x > 80) {
      EXPECT_NEAR(cloud.radii[i], 4.0f, 1.4f);
    }
  }
}

TEST(Radii, do_not_shrink_at_duplicate_points) {
  Surface once = sphere(5000);
  PointCloud twice = once.cloud;
  twice.positions.insert(twice.positions.end(), once.cloud.positions.begin(),
                         once.cloud.positions.end());
  estimate_normals_and_radii(once.cloud);
  estimate_normals_and_radii(twice);
  for (std::size_t i = 0; i < once.cloud.size(); ++i) {
    EXPECT_FLOAT_EQ(twice.radii[i], once.cloud.radii[i]);
  }
}

/// Checks that normals are unit or zero and that radii are finite and positive.
void expect_sound(const PointCloud& cloud) {
  ASSERT_EQ(cloud.normals.size(), cloud.size());
  ASSERT_EQ(cloud.radii.size(), cloud.size());
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const float length = glm::length(cloud.normals[i]);
    EXPECT_TRUE(length == 0.0f || std::abs(length - 1.0f) < 1e-3f) << length;
    EXPECT_TRUE(std::isfinite(cloud.radii[i]) && cloud.radii[i] > 0.0f) << cloud.radii[i];
  }
}

PointCloud estimated(std::vector<glm::vec3> positions) {
  PointCloud cloud;
  cloud.positions = std::move(positions);
  estimate_normals_and_radii(cloud);
  expect_sound(cloud);
  return cloud;
}

TEST(Normals, of_points_that_lack_them_are_completed_and_the_others_kept) {
  for (const std::size_t lacking : {1u, 60u, 700u}) {
    Surface surface = torus(20'000);
    PointCloud& cloud = surface.cloud;
    for (const glm::dvec3& normal : surface.normals) cloud.normals.emplace_back(normal);
    const std::size_t step = cloud.size() / lacking;
    for (std::size_t k = 0; k < lacking; ++k) cloud.normals[k * step] = glm::vec3(0.0f);
    complete_normals(cloud);
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      const glm::vec3 truth(surface.normals[i]);
      const bool completed = i % step == 0 && i / step < lacking;
      EXPECT_GT(glm::dot(cloud.normals[i], truth), completed ? 0.97f : 0.99999f) << lacking;
    }
  }
  // Where those around a point do not agree, as on two sides of a sheet, all are estimated.
  PointCloud sheet;
  for (int i = 0; i < 800; ++i) {
    sheet.positions.emplace_back(i / 2 % 20, i / 40, 0.01f * static_cast<float>(i % 2));
    sheet.normals.emplace_back(0.0f, 0.0f, i % 2 == 0 ? -1.0f : 1.0f);
  }
  sheet.normals[405] = glm::vec3(0.0f);
  const glm::vec3 expected = estimated(sheet.positions).normals[405];
  complete_normals(sheet);
  EXPECT_EQ(sheet.normals[405], expected);
}

TEST(Normals, are_unknown_if_no_plane_fits) {
  EXPECT_TRUE(estimated({}).empty());
  const glm::vec3 unknown(0.0f);
  EXPECT_EQ(estimated({{1, 2, 3}}).normals[0], unknown);
  EXPECT_EQ(estimated({{1, 2, 3}, {2, 2, 3}}).normals[1], unknown);
  EXPECT_EQ(estimated(std::vector<glm::vec3>(1000, {7, 7, 7})).normals[500], unknown);
  std::vector<glm::vec3> line;
  for (int i = 0; i < 500; ++i) line.push_back(glm::vec3(1, 2, -3) * static_cast<float>(i));
  for (const glm::vec3& n : estimated(line).normals) EXPECT_EQ(n, unknown);
  for (glm::vec3& p : line) p = {p.x, 0, 0};
  for (const glm::vec3& n : estimated(line).normals) EXPECT_EQ(n, unknown);
}

TEST(Normals, are_those_of_the_triangle_for_three_points) {
  const PointCloud cloud = estimated({{0, 0, 5}, {1, 0, 5}, {0, 1, 5}});
  for (const glm::vec3& n : cloud.normals) EXPECT_NEAR(std::abs(n.z), 1.0f, 1e-5f);
}

TEST(Normals, are_finite_units_for_extreme_coordinates) {
  std::mt19937 random(3);
  std::normal_distribution<float> normal;
  for (const float scale : {1e-44f, 1e-38f, 1e-20f, 1e20f, 1e37f}) {
    std::vector<glm::vec3> positions;
    for (int i = 0; i < 500; ++i) {
      positions.push_back(glm::vec3(normal(random), normal(random), normal(random)) * scale);
    }
    estimated(positions);
  }
  constexpr float kMax = std::numeric_limits<float>::max();
  estimated({{-kMax, -kMax, 0}, {kMax, kMax, 0}, {kMax, -kMax, 1}, {0, 0, 0}});
  // One stray point far away from a small cluster.
  Surface stray = sphere(2000);
  stray.cloud.positions.emplace_back(1e6f, 0, 0);
  estimated(stray.cloud.positions);
}

TEST(NodeBlocks, hold_the_nodes_in_the_cells_around_each_node) {
  Surface surface = sphere(500);
  for (const int depth : {0, 1, 2, 5}) {
    const SortedPoints sorted = sort_points(surface.cloud, bounding_cube(bounds(surface.cloud)));
    const Svo svo = build_svo(sorted, depth);
    const std::vector<NodeBlock> blocks = node_blocks(svo);
    ASSERT_EQ(blocks.size(), svo.node_count());
    const std::vector<glm::uvec3> cells = leaf_cells(svo);
    const std::uint32_t leaves = svo.level_begin[static_cast<std::size_t>(depth)];
    for (std::size_t i = 0; i < cells.size(); ++i) {
      NodeBlock expected;
      expected.fill(kNoNode);
      for (std::size_t k = 0; k < cells.size(); ++k) {
        const glm::ivec3 d = glm::ivec3(cells[k]) - glm::ivec3(cells[i]) + 1;
        if (std::min({d.x, d.y, d.z}) < 0 || std::max({d.x, d.y, d.z}) > 2) continue;
        expected[static_cast<std::size_t>(d.x + 3 * d.y + 9 * d.z)] =
            leaves + static_cast<std::uint32_t>(k);
      }
      ASSERT_EQ(blocks[leaves + i], expected) << depth << " " << i;
    }
  }
}

TEST(Openness, counts_the_directions_that_leave_the_grid) {
  std::mt19937 random(4);
  for (const int level : {1, 3, 5, 7}) {
    const int side = 1 << level;
    PointCloud cloud;
    std::vector<char> full(static_cast<std::size_t>(side * side * side), 0);
    const auto at = [side](const glm::ivec3& c) {
      return static_cast<std::size_t>(c.x + side * (c.y + side * c.z));
    };
    for (int i = 0; i < 2 * side * side; ++i) {
      const glm::ivec3 cell(random() % static_cast<unsigned>(side),
                            random() % static_cast<unsigned>(side),
                            random() % static_cast<unsigned>(side));
      // The cells are dense in one corner, so that some are enclosed.
      if (cell.x + cell.y > side && i % 3 != 0) continue;
      full[at(cell)] = 1;
      cloud.positions.emplace_back(glm::vec3(cell) + 0.5f);
    }
    const Svo svo =
        build_svo(sort_points(cloud, {glm::dvec3(0.0), static_cast<double>(side)}), level);
    const Openness openness(svo, level);
    EXPECT_EQ(openness.at(glm::vec3(-0.5f)), 26);
    for (int i = 0; i < 2000; ++i) {
      const glm::ivec3 cell(random() % static_cast<unsigned>(side),
                            random() % static_cast<unsigned>(side),
                            random() % static_cast<unsigned>(side));
      int expected = 0;
      for (int d = 0; d < 27; ++d) {
        const glm::ivec3 step(d % 3 - 1, d / 3 % 3 - 1, d / 9 - 1);
        if (d == 13) continue;
        glm::ivec3 c = cell;
        while (std::min({c.x, c.y, c.z}) >= 0 && std::max({c.x, c.y, c.z}) < side &&
               full[at(c)] == 0) {
          c += step;
        }
        expected += std::min({c.x, c.y, c.z}) < 0 || std::max({c.x, c.y, c.z}) >= side ? 1 : 0;
      }
      ASSERT_EQ(openness.at(glm::vec3(cell) + 0.5f), expected) << level;
    }
  }
}

}  // namespace
}  // namespace pointreel::normals_test
