#include "client/scene/cut.h"

#include <algorithm>
#include <bit>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <random>
#include <set>
#include <vector>

#include <gtest/gtest.h>

#include "codec/core/build.h"
#include "pointreel/octree.h"

namespace pointreel::cut_test {
namespace {

constexpr glm::ivec2 kSize(640, 480);

PointCloud shell(std::size_t n, const glm::dvec3& origin = glm::dvec3(0.0)) {
  std::mt19937 random(7);
  std::normal_distribution<float> normal;
  PointCloud cloud;
  cloud.origin = origin;
  for (std::size_t i = 0; i < n; ++i) {
    const glm::vec3 p(normal(random), normal(random), normal(random));
    cloud.positions.push_back(glm::normalize(p) * glm::vec3(0.4f, 1.0f, 0.3f));
  }
  return cloud;
}

Svo tree(const PointCloud& cloud, int depth) {
  return build_svo(sort_points(cloud, bounding_cube(bounds(cloud))), depth);
}

/// The parent and level of every node and the emitted ancestors of each leaf, found the slow way.
struct Ancestry {
  explicit Ancestry(const Svo& svo) : parent(svo.node_count(), 0) {
    for (std::uint32_t i = 0; i < svo.internal_count(); ++i) {
      for (int c = 0; c < std::popcount(svo.masks[i]); ++c) {
        parent[svo.first_child[i] + static_cast<unsigned>(c)] = i;
      }
    }
  }
  std::vector<std::uint32_t> parent;
};

std::vector<std::uint32_t> covering(const Svo& svo, const Ancestry& ancestry,
                                    const std::set<std::uint32_t>& emitted, std::uint32_t leaf) {
  std::vector<std::uint32_t> found;
  std::uint32_t node = svo.internal_count() + leaf;
  for (;; node = ancestry.parent[node]) {
    if (emitted.count(node)) found.push_back(node);
    if (node == 0) return found;
  }
}

bool in_frustum(const Camera& camera, const glm::dvec3& world) {
  const glm::dvec3 e = glm::transpose(camera.axes()) * (world - camera.eye());
  const double t = std::tan(0.5 * camera.fov_y);
  return -e.z >= camera.near_plane() && std::abs(e.y) <= -e.z * t &&
         std::abs(e.x) <= -e.z * t * kSize.x / kSize.y;
}

bool leaf_visible(const Camera& camera, const Svo& svo, const glm::uvec3& cell) {
  const double size = svo.cell_size(svo.depth);
  const glm::dvec3 min = svo.cube.origin + glm::dvec3(cell) * size;
  if (in_frustum(camera, min + 0.5 * size)) return true;
  for (int i = 0; i < 8; ++i) {
    if (in_frustum(camera, min + size * glm::dvec3(i & 1, i >> 1 & 1, i >> 2))) return true;
  }
  return false;
}

TEST(Cut, never_culls_a_leaf_that_brute_force_finds_visible) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  for (const glm::dvec3& origin : {glm::dvec3(0.0), glm::dvec3(1e6, -2e6, 5e5)}) {
    const PointCloud cloud = shell(3000, origin);
    const Svo svo = tree(cloud, 7);
    const std::vector<glm::uvec3> cells = leaf_cells(svo);
    const Ancestry ancestry(svo);
    VoxelCut cut;
    for (int trial = 0; trial < 60; ++trial) {
      Camera camera;
      camera.target = origin + glm::dvec3(unit(random), unit(random), unit(random));
      camera.distance = std::exp2(4.0 * unit(random) - 1.0);
      camera.orbit(3.2 * unit(random), 1.5 * unit(random));
      camera.up = trial & 1 ? 'y' : 'z';
      camera.fov_y = 0.6 + 0.5 * unit(random);
      const float pixel_size = trial % 3 == 0 ? 0.0f : 1.0f + 3.0f * static_cast<float>(trial % 5);
      const CutStats stats = cut.run(svo, camera, kSize, pixel_size);
      ASSERT_EQ(stats.emitted, cut.nodes().size());
      std::set<std::uint32_t> emitted;
      for (const CutNode& n : cut.nodes()) {
        ASSERT_TRUE(emitted.insert(n.node).second) << "the node is emitted twice";
      }
      for (std::uint32_t leaf = 0; leaf < cells.size(); ++leaf) {
        const auto nodes = covering(svo, ancestry, emitted, leaf);
        ASSERT_LE(nodes.size(), 1u) << "a voxel inside another voxel is drawn";
        if (leaf_visible(camera, svo, cells[leaf])) {
          ASSERT_EQ(nodes.size(), 1u) << "trial " << trial << " leaf " << leaf;
        }
      }
    }
  }
}

TEST(Cut, gives_every_emitted_node_its_position_and_size) {
  const PointCloud cloud = shell(3000);
  const Svo svo = tree(cloud, 6);
  const std::vector<glm::uvec3> cells = leaf_cells(svo);
  Camera camera;
  camera.frame_bounds(bounds(cloud), 4.0 / 3.0);
  VoxelCut cut;
  const CutStats stats = cut.run(svo, camera, kSize, 0.0f);
  EXPECT_EQ(stats.emitted, svo.leaf_count());
  EXPECT_EQ(stats.visited, svo.node_count());
  for (const CutNode& n : cut.nodes()) {
    const glm::uvec3 cell = cells[n.node - svo.internal_count()];
    const double size = svo.cell_size(svo.depth);
    EXPECT_NEAR(n.half, 0.5 * size, 1e-7);
    EXPECT_LT(glm::length(glm::dvec3(n.center) - (glm::dvec3(cell) + 0.5) * size), 1e-6);
  }
}

TEST(Cut, places_every_node_of_trees_with_one_to_eight_children_a_node) {
  std::mt19937 random(5);
  for (const double share : {0.02, 0.3, 0.6, 1.0}) {
    PointCloud cloud;
    for (int i = 0; i < 32 * 32 * 32; ++i) {
      if (std::uniform_real_distribution<>(0.0, 1.0)(random) > share && i > 0) continue;
      cloud.positions.push_back(glm::vec3(i % 32, i / 32 % 32, i / 1024) + 0.5f);
    }
    const Svo svo = build_svo(sort_points(cloud, Cube{glm::dvec3(0.0), 32.0}), 5);
    const std::vector<glm::uvec3> cells = leaf_cells(svo);
    Camera camera;
    camera.frame_bounds({glm::dvec3(0.0), glm::dvec3(32.0)}, 4.0 / 3.0);
    VoxelCut cut;
    for (const double distance : {1.0, 0.3}) {  // with all and with part of it inside the frustum
      camera.zoom(distance);
      cut.run(svo, camera, kSize, 0.0f);
      ASSERT_FALSE(cut.nodes().empty());
      for (const CutNode& n : cut.nodes()) {
        ASSERT_EQ(n.half, 0.5f);
        ASSERT_EQ(n.center, glm::vec3(cells[n.node - svo.internal_count()]) + 0.5f);
      }
    }
  }
}

TEST(Cut, culls_nodes_behind_the_eye_and_outside_the_picture) {
  const PointCloud cloud = shell(3000);
  const Svo svo = tree(cloud, 6);
  Camera camera;
  camera.target = glm::dvec3(0.0, 0.0, 20.0);
  camera.distance = 1.0;
  VoxelCut cut;
  camera.yaw = 3.14159265358979;  // the eye is at z = 19 and looks away along +z
  CutStats stats = cut.run(svo, camera, kSize, 1.0f);
  EXPECT_EQ(stats.emitted, 0u);
  EXPECT_EQ(stats.visited, 1u);
  camera.yaw = 0.0;  // the eye is at z = 21 and looks back at the cloud
  EXPECT_GT(cut.run(svo, camera, kSize, 1.0f).emitted, 100u);
  camera.target.x += 40.0;
  EXPECT_EQ(cut.run(svo, camera, kSize, 1.0f).emitted, 0u);
}

TEST(Cut, emits_only_nodes_that_cover_less_than_a_pixel) {
  const PointCloud cloud = shell(20000);
  const Svo svo = tree(cloud, 9);
  VoxelCut cut;
  for (const double distance : {20.0, 60.0, 500.0, 1e5}) {
    Camera camera;
    camera.distance = distance;
    cut.run(svo, camera, kSize, 1.0f);
    ASSERT_FALSE(cut.nodes().empty());
    const double focal = 0.5 * kSize.y / std::tan(0.5 * camera.fov_y);
    for (const CutNode& n : cut.nodes()) {
      // On the axis and at this distance, a cube's mean projected area is 6 half^2 (focal / z)^2.
      const double z =
          -(glm::transpose(camera.axes()) * (svo.cube.origin + glm::dvec3(n.center) - camera.eye()))
               .z;
      const double area = 6.0 * n.half * n.half * focal * focal / (z * z);
      if (n.node < svo.internal_count()) {
        EXPECT_LT(area, 1.01);
      }
      EXPECT_GT(4.0 * area, n.node == 0 ? 0.0 : 0.9) << "the parent would have been small enough";
    }
  }
}

TEST(Cut, descends_into_nodes_around_the_eye_or_across_the_near_plane) {
  const PointCloud cloud = shell(20000);
  const Svo svo = tree(cloud, 9);
  VoxelCut cut;
  Camera camera;
  camera.target = glm::dvec3(0.0, 0.0, -0.5);  // the eye is in the middle of the shell
  camera.distance = 0.5;
  // A node around the eye must not be emitted, however coarse the wanted pixels are.
  const CutStats stats = cut.run(svo, camera, kSize, 400.0f);
  EXPECT_GT(stats.emitted, 0u);
  for (const CutNode& n : cut.nodes()) {
    if (n.node >= svo.internal_count()) continue;
    const double z =
        -(glm::transpose(camera.axes()) * (svo.cube.origin + glm::dvec3(n.center) - camera.eye()))
             .z;
    EXPECT_GT(z, std::sqrt(3.0) * n.half + camera.near_plane());
  }
}

TEST(Cut, handles_empty_trees_single_leaves_and_the_deepest_trees) {
  VoxelCut cut;
  Camera camera;
  EXPECT_EQ(cut.run(Svo{}, camera, kSize, 1.0f).emitted, 0u);

  PointCloud point;
  point.positions = {glm::vec3(0.25f)};
  const Svo single = tree(point, 0);
  EXPECT_EQ(cut.run(single, camera, kSize, 1.0f).emitted, 1u);
  EXPECT_EQ(cut.nodes()[0].node, 0u);

  const PointCloud cloud = shell(200);
  const Svo deep = tree(cloud, kMaxDepth);
  camera.distance = 1.5;
  const CutStats stats = cut.run(deep, camera, kSize, 0.0f);
  const std::vector<glm::uvec3> cells = leaf_cells(deep);
  EXPECT_GT(stats.emitted, 0u);
  for (const CutNode& n : cut.nodes()) {
    ASSERT_GE(n.node, deep.internal_count());
    const double size = deep.cell_size(kMaxDepth);
    const glm::dvec3 expected = (glm::dvec3(cells[n.node - deep.internal_count()]) + 0.5) * size;
    EXPECT_LT(glm::length(glm::dvec3(n.center) - expected), size);
  }
}

TEST(Cut, counts_the_leaves_that_it_culls) {
  const PointCloud cloud = shell(3000);
  const Svo svo = tree(cloud, 7);
  const Ancestry ancestry(svo);
  std::mt19937 random(9);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  VoxelCut cut;
  for (int trial = 0; trial < 20; ++trial) {
    Camera camera;
    camera.target = glm::dvec3(unit(random), unit(random), unit(random));
    camera.distance = std::exp2(4.0 * unit(random));
    const CutStats stats = cut.run(svo, camera, kSize, 2.0f);
    std::set<std::uint32_t> emitted;
    for (const CutNode& n : cut.nodes()) emitted.insert(n.node);
    std::uint32_t uncovered = 0;
    for (std::uint32_t leaf = 0; leaf < svo.leaf_count(); ++leaf) {
      uncovered += covering(svo, ancestry, emitted, leaf).empty();
    }
    EXPECT_EQ(stats.out_of_view, uncovered);
  }
}

TEST(FinestLevel, is_never_coarser_than_a_node_that_a_cut_emits) {
  std::mt19937 random(4);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  for (const glm::dvec3& origin : {glm::dvec3(0.0), glm::dvec3(1e6, -2e6, 5e5)}) {
    const PointCloud cloud = shell(3000, origin);
    const Svo svo = tree(cloud, 10);
    VoxelCut cut;
    int near = 0;
    for (int trial = 0; trial < 200; ++trial) {
      Camera camera;
      camera.target = origin + 0.7 * glm::dvec3(unit(random), unit(random), unit(random));
      camera.distance = std::exp2(6.0 + 5.0 * unit(random));
      camera.orbit(3.2 * unit(random), 1.5 * unit(random));
      camera.fov_y = 0.8 + 0.7 * unit(random);
      const float pixel_size = trial % 4 == 0 ? 4.0f : 1.0f;
      const int level = finest_level(svo.cube, bounds(cloud), camera, kSize, pixel_size);
      cut.run(svo, camera, kSize, pixel_size);
      int finest = 0;
      for (const CutNode& n : cut.nodes()) {
        for (int l = finest; l <= svo.depth; ++l) {
          if (n.node >= svo.level_begin[static_cast<std::size_t>(l)]) finest = l;
        }
      }
      ASSERT_LE(finest, level) << "trial " << trial;
      near += finest >= std::min(level, svo.depth) - 1;
    }
    EXPECT_GT(near, 150) << "the level is much too fine although all is in the picture";
  }
}

TEST(FinestLevel, rises_with_the_height_of_a_person_in_pixels) {
  const Box person{{-0.3, 0.0, -0.3}, {0.3, 1.8, 0.3}};
  const Cube cube{{-0.9, 0.0, -0.9}, 1.8};
  Camera camera;
  for (const auto& [pixels, level] : {std::pair{90, 7}, {300, 9}, {700, 10}, {1400, 11}}) {
    camera.frame_bounds(person, 1.0);
    // The person is slightly smaller than the picture.
    EXPECT_EQ(finest_level(cube, person, camera, glm::ivec2(pixels), 1.0f), level) << pixels;
  }
  EXPECT_EQ(finest_level(cube, person, camera, kSize, 0.0f), kMaxDepth) << "leaves are wanted";
  EXPECT_EQ(finest_level(cube, Box{}, camera, kSize, 1.0f), 0);
  camera.target = person.center();
  camera.distance = 0.1;
  EXPECT_EQ(finest_level(cube, person, camera, kSize, 1.0f), kMaxDepth);
}

}  // namespace
}  // namespace pointreel::cut_test
