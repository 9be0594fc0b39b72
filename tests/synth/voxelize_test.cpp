#include "datasets_synthetic/voxelize.h"

#include <array>
#include <cmath>
#include <set>
#include <vector>

#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include "datasets_synthetic/motion.h"
#include "datasets_synthetic/samplers/uniform.h"

namespace pointreel::voxelize_test {
namespace {

/// A body without a skeleton, for shapes that are easily judged.
Body body_of(Surface surface) {
  Body body;
  body.parts.assign(surface.primitives.size(), {Bone::chest, Material::shirt});
  body.surface = std::move(surface);
  return body;
}

Body ball() {
  const glm::dvec3 center(0.3, 1.0, -0.2);
  return body_of({{RoundCone{center, center, 0.25, 0.25}}, {{0, 0, 0.0}}});
}

/// A ball and a round cone that blend, and a tilted ellipsoid without a blend.
Body group() {
  const glm::dmat3 turned(0.6, 0.8, 0, -0.8, 0.6, 0, 0, 0, 1);
  return body_of({{RoundCone{{0, 0, 0}, {0, 0, 0}, 0.2, 0.2},
                   RoundCone{{0.3, 0.1, 0.05}, {0.4, 0.2, 0.05}, 0.15, 0.1},
                   Ellipsoid{{0.1, 0.5, 0.3}, turned, {0.3, 0.12, 0.1}}},
                  {{0, 1, 0.1}, {2, 2, 0.0}}});
}

using Cells = std::set<std::array<int, 3>>;

Cells cells_of(const PointCloud& cloud) {
  Cells cells;
  for (const glm::vec3& p : cloud.positions) {
    cells.insert({static_cast<int>(p.x), static_cast<int>(p.y), static_cast<int>(p.z)});
  }
  return cells;
}

struct Voxelized {
  VoxelGrid grid;
  PointCloud cloud;
  Cells cells;
};

Voxelized voxelized(const Body& body, int bits) {
  Voxelized result;
  result.grid = voxel_grid(bounds(body.surface), bits);
  result.cloud = voxelize(body, result.grid).value();
  result.cells = cells_of(result.cloud);
  return result;
}

/// Whether the surface passes between two points, tested at 16 places in between.
bool edge_meets(const Surface& surface, const glm::dvec3& a, const glm::dvec3& b) {
  const bool inside = distance_to(surface, a).distance.value < 0.0;
  for (int i = 1; i <= 16; ++i) {
    const glm::dvec3 p = a + (b - a) * (i / 16.0);
    if ((distance_to(surface, p).distance.value < 0.0) != inside) return true;
  }
  return false;
}

TEST(Voxelize, gives_exactly_the_voxels_with_an_edge_through_the_surface) {
  const Body body = group();
  const Voxelized result = voxelized(body, 5);
  Cells expected;
  const double reach = std::sqrt(3.0) * result.grid.voxel;
  for (int i = 0; i < 33 * 33 * 33; ++i) {  // corners, and the three edges that begin there
    const glm::ivec3 corner(i % 33, i / 33 % 33, i / (33 * 33));
    const glm::dvec3 a = result.grid.origin + result.grid.voxel * (glm::dvec3(corner) - 0.5);
    if (std::abs(distance_to(body.surface, a).distance.value) > reach) continue;
    for (int axis = 0; axis < 3; ++axis) {
      glm::dvec3 b = a;
      b[axis] += result.grid.voxel;
      if (corner[axis] == 32 || !edge_meets(body.surface, a, b)) continue;
      for (int side = 0; side < 4; ++side) {
        glm::ivec3 cell = corner;
        cell[(axis + 1) % 3] -= side & 1;
        cell[(axis + 2) % 3] -= side >> 1;
        expected.insert({cell.x, cell.y, cell.z});
      }
    }
  }
  EXPECT_GT(expected.size(), 1000u);
  EXPECT_EQ(result.cells, expected);
}

TEST(Voxelize, contains_every_voxel_that_dense_samples_hit_except_at_tips) {
  const Body body = pose_body(walk(0.4));
  const Voxelized result = voxelized(body, 6);
  const auto samples = sample_uniform(body.surface, 60000, 3).value();
  Cells hit;
  for (const SurfacePoint& point : samples) {
    const glm::ivec3 cell(glm::round((point.position - result.grid.origin) / result.grid.voxel));
    hit.insert({cell.x, cell.y, cell.z});
  }
  std::size_t missing = 0, unseen = 0;
  for (const auto& cell : hit) missing += !result.cells.contains(cell);
  for (const auto& cell : result.cells) unseen += !hit.contains(cell);
  EXPECT_LE(missing, hit.size() / 100);
  EXPECT_LE(unseen, hit.size() / 10);  // voxels of which the surface only cuts off a corner
}

TEST(Voxelize, gives_one_point_a_voxel_at_integer_coordinates_that_fill_the_cube) {
  const Voxelized result = voxelized(ball(), 6);
  EXPECT_EQ(result.cells.size(), result.cloud.size());
  glm::vec3 low(1e9f), high(-1e9f);
  for (const glm::vec3& p : result.cloud.positions) {
    EXPECT_EQ(p, glm::round(p));
    low = glm::min(low, p);
    high = glm::max(high, p);
  }
  EXPECT_EQ(low, glm::vec3(0));
  EXPECT_EQ(high, glm::vec3(63));
  // 1.5 area / voxel^2: the diameter is 63 voxels.
  const double expected = 1.5 * 3.14159 * 63 * 63;
  EXPECT_NEAR(static_cast<double>(result.cloud.size()), expected, 0.03 * expected);
  EXPECT_EQ(result.cloud.origin, glm::dvec3(0.0));
}

/// The sizes of the connected components of the cells.
std::vector<std::size_t> components(Cells cells) {
  std::vector<std::size_t> sizes;
  while (!cells.empty()) {
    std::vector<std::array<int, 3>> open{*cells.begin()};
    cells.erase(cells.begin());
    std::size_t size = 0;
    for (; !open.empty(); ++size) {
      const auto cell = open.back();
      open.pop_back();
      for (int i = 0; i < 27; ++i) {
        const auto found =
            cells.find({cell[0] + i % 3 - 1, cell[1] + i / 3 % 3 - 1, cell[2] + i / 9 - 1});
        if (found == cells.end()) continue;
        open.push_back(*found);
        cells.erase(found);
      }
    }
    sizes.push_back(size);
  }
  return sizes;
}

TEST(Voxelize, gives_voxels_as_connected_as_the_surface) {
  EXPECT_EQ(components(voxelized(ball(), 6).cells).size(), 1u);
  EXPECT_EQ(components(voxelized(group(), 6).cells).size(), 2u);
  EXPECT_EQ(components(voxelized(pose_body(walk(0.4)), 7).cells).size(), 1u);
}

TEST(Voxelize, leaves_no_hole_into_the_inside) {
  const Body body = pose_body(walk(0.4));
  const Voxelized result = voxelized(body, 6);
  // Flood from outside through the faces of empty voxels, with a layer of cells around the grid.
  std::vector<char> reached(66 * 66 * 66, 0);
  const auto at = [](const glm::ivec3& c) {
    return static_cast<std::size_t>(c.x + 1 + 66 * (c.y + 1 + 66 * (c.z + 1)));
  };
  for (const auto& cell : result.cells) reached[at({cell[0], cell[1], cell[2]})] = 2;
  std::vector<glm::ivec3> open{glm::ivec3(-1)};
  reached[at(open.back())] = 1;
  while (!open.empty()) {
    const glm::ivec3 cell = open.back();
    open.pop_back();
    for (int side = 0; side < 6; ++side) {
      glm::ivec3 next = cell;
      next[side / 2] += side % 2 == 0 ? -1 : 1;
      if (next[side / 2] < -1 || next[side / 2] > 64 || reached[at(next)] != 0) continue;
      reached[at(next)] = 1;
      open.push_back(next);
    }
  }
  int inside = 0;
  for (int i = 0; i < 64 * 64 * 64; ++i) {
    const glm::ivec3 cell(i % 64, i / 64 % 64, i / 4096);
    if (reached[at(cell)] != 0) continue;
    ++inside;
    const glm::dvec3 center = result.grid.origin + result.grid.voxel * glm::dvec3(cell);
    EXPECT_LT(distance_to(body.surface, center).distance.value, 0.0);
  }
  EXPECT_GT(inside, 500);
}

TEST(Voxelize, takes_normals_and_colours_from_the_nearby_surface) {
  const Voxelized result = voxelized(ball(), 7);
  for (std::size_t i = 0; i < result.cloud.size(); ++i) {
    const glm::dvec3 p =
        result.grid.origin + result.grid.voxel * glm::dvec3(result.cloud.positions[i]);
    const glm::dvec3 outwards = glm::normalize(p - glm::dvec3(0.3, 1.0, -0.2));
    EXPECT_GT(glm::dot(glm::dvec3(result.cloud.normals[i]), outwards), 0.999);
    EXPECT_EQ(result.cloud.colors[i].x % 257, 0);
  }
}

TEST(Voxelize, gives_the_same_cloud_on_any_number_of_threads) {
  const Body body = group();
  std::vector<PointCloud> clouds;
  for (const int threads : {1, 3}) {
    tbb::task_arena arena(threads);
    arena.execute([&] { clouds.push_back(voxelized(body, 6).cloud); });
  }
  EXPECT_EQ(clouds[0].positions, clouds[1].positions);
  EXPECT_EQ(clouds[0].normals, clouds[1].normals);
  EXPECT_EQ(clouds[0].colors, clouds[1].colors);
}

}  // namespace
}  // namespace pointreel::voxelize_test
