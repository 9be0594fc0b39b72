#include "client/strips/strips.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <random>
#include <set>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "client/prepare/strip_frame.h"
#include "tests/executors.h"

namespace pointreel::strips_test {
namespace {

using Corners = std::array<std::uint32_t, 3>;

std::vector<Corners> triangles_of(std::span<const std::uint32_t> indices) {
  std::vector<Corners> all;
  std::size_t begin = 0;
  for (std::size_t i = 0; i < indices.size(); ++i) {
    if (indices[i] == kEndOfStrip) {
      EXPECT_GE(i, begin + 3) << "a strip without a triangle";
      begin = i + 1;
    } else if (i >= begin + 2) {
      const bool turned = (i - begin) % 2 != 0;
      all.push_back({indices[i - 2], indices[turned ? i : i - 1], indices[turned ? i - 1 : i]});
    }
  }
  EXPECT_EQ(begin, indices.size()) << "the last strip does not end";
  return all;
}

/// How the triangles of a surface lie to each other.
struct Topology {
  std::size_t triangles = 0, rim = 0, doubled = 0, vertices = 0;
};
Topology topology_of(const std::vector<Corners>& triangles) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges;
  std::set<std::uint32_t> vertices;
  Topology topology{.triangles = triangles.size()};
  for (const Corners& corners : triangles) {
    for (std::size_t i = 0; i < 3; ++i) {
      vertices.insert(corners[i]);
      if (++edges[{corners[i], corners[(i + 1) % 3]}] > 1) ++topology.doubled;
    }
  }
  for (const auto& [edge, count] : edges)
    if (!edges.contains({edge.second, edge.first})) ++topology.rim;
  topology.vertices = vertices.size();
  return topology;
}

/// Makes the strips of a cloud of points with normals and one radius.
SceneFrame stripped(PointCloud cloud, float radius, bool lines = false,
                    const Executor& executor = {}) {
  SceneFrame scene;
  cloud.radii.assign(cloud.size(), radius);
  scene.cloud = std::move(cloud);
  scene.normals_estimated = lines;
  make_strips(scene, executor);
  return scene;
}

/// Random points on a sphere with radius 1, and the radius of surfels that cover it.
constexpr int kOnSphere = 20'000;
const float kSphereRadius = std::sqrt(4.0f * 3.14159f / kOnSphere);
PointCloud sphere(int seed = 1) {
  std::mt19937 random(seed);
  std::normal_distribution<float> normal;
  PointCloud cloud;
  for (int i = 0; i < kOnSphere; ++i) {
    const glm::vec3 p = glm::normalize(glm::vec3(normal(random), normal(random), normal(random)));
    cloud.positions.push_back(p);
    cloud.normals.push_back(p);
  }
  return cloud;
}

/// A grid of points in a plane, from 0 to `size` both ways, `step` apart.
PointCloud plate(int size, float step, float height = 0.0f, const glm::vec3& normal = {0, 0, 1}) {
  PointCloud cloud;
  for (int y = 0; y <= size; ++y) {
    for (int x = 0; x <= size; ++x) {
      cloud.positions.emplace_back(step * glm::vec2(x, y), height);
      cloud.normals.push_back(normal);
    }
  }
  return cloud;
}

void append(PointCloud& cloud, const PointCloud& more) {
  cloud.positions.insert(cloud.positions.end(), more.positions.begin(), more.positions.end());
  cloud.normals.insert(cloud.normals.end(), more.normals.begin(), more.normals.end());
}

TEST(Strips, close_a_sphere_of_random_points_and_hardly_overlap) {
  const SceneFrame scene = stripped(sphere(), kSphereRadius);
  const std::vector<Corners> triangles = triangles_of(scene.strips.indices);
  const Topology topology = topology_of(triangles);
  EXPECT_EQ(topology.vertices, scene.cloud.size());
  // A closed surface has twice as many triangles as vertices, less four.
  EXPECT_NEAR(static_cast<double>(triangles.size()) / static_cast<double>(topology.vertices), 2.0,
              0.02);
  EXPECT_LT(topology.rim, triangles.size() / 50);
  EXPECT_LT(topology.doubled, triangles.size() / 50);
  for (const auto& [a, b, c] : triangles) {
    const glm::vec3 &p = scene.cloud.positions[a], &q = scene.cloud.positions[b],
                    &r = scene.cloud.positions[c];
    const glm::vec3 outwards = p + glm::vec3(scene.cloud.origin);
    ASSERT_GT(glm::dot(glm::cross(q - p, r - p), outwards), 0.0f) << "a triangle faces inwards";
  }
}

/// The share of random directions in which a ray from the middle of a sphere meets no triangle.
double open_share(const SceneFrame& scene) {
  // Directions are looked up among triangles near them.
  constexpr int kCells = 24;
  std::map<std::array<int, 3>, std::vector<Corners>> near;
  const auto cell = [](const glm::vec3& p) {
    const glm::ivec3 at(glm::floor(p * static_cast<float>(kCells / 2)));
    return std::array<int, 3>{at.x, at.y, at.z};
  };
  for (const Corners& corners : triangles_of(scene.strips.indices)) {
    glm::vec3 low(2.0f), high(-2.0f);
    for (const std::uint32_t i : corners) {
      const glm::vec3 p = scene.cloud.positions[i] + glm::vec3(scene.cloud.origin);
      low = glm::min(low, p);
      high = glm::max(high, p);
    }
    const auto from = cell(low - 0.01f), to = cell(high + 0.01f);
    for (int x = from[0]; x <= to[0]; ++x)
      for (int y = from[1]; y <= to[1]; ++y)
        for (int z = from[2]; z <= to[2]; ++z) near[{x, y, z}].push_back(corners);
  }
  std::mt19937 random(9);
  std::normal_distribution<float> normal;
  constexpr int kRays = 20'000;
  int open = 0;
  for (int i = 0; i < kRays; ++i) {
    const glm::vec3 ray = glm::normalize(glm::vec3(normal(random), normal(random), normal(random)));
    const auto& candidates = near[cell(ray)];
    const bool met = std::any_of(candidates.begin(), candidates.end(), [&](const Corners& corners) {
      std::array<glm::vec3, 3> p;
      for (std::size_t k = 0; k < 3; ++k)
        p[k] = scene.cloud.positions[corners[k]] + glm::vec3(scene.cloud.origin);
      return glm::dot(ray, glm::cross(p[0], p[1])) >= -1e-7f &&
             glm::dot(ray, glm::cross(p[1], p[2])) >= -1e-7f &&
             glm::dot(ray, glm::cross(p[2], p[0])) >= -1e-7f;
    });
    if (!met) ++open;
  }
  return open / static_cast<double>(kRays);
}

TEST(Strips, leave_hardly_a_crack_in_a_sphere) {
  EXPECT_LT(open_share(stripped(sphere(), kSphereRadius)), 0.002);
}

TEST(Strips, do_not_depend_on_threads) {
  const SceneFrame expected = stripped(sphere(), kSphereRadius);
  for (const Executor& executor : some_executors()) {
    const SceneFrame scene = stripped(sphere(), kSphereRadius, false, executor);
    EXPECT_EQ(scene.strips.indices, expected.strips.indices);
    EXPECT_EQ(scene.strips.nodes.size(), expected.strips.nodes.size());
  }
}

TEST(Strips, triangulate_a_grid_without_overlap) {
  const SceneFrame scene = stripped(plate(60, 0.01f), 0.01f);
  const Topology topology = topology_of(triangles_of(scene.strips.indices));
  EXPECT_EQ(topology.triangles, 2u * 60 * 60);
  EXPECT_EQ(topology.doubled, 0u);
  EXPECT_EQ(topology.rim, 4u * 60);
}

TEST(Strips, leave_holes_open_that_are_wider_than_surfels_reach) {
  PointCloud cloud = plate(60, 0.01f), with_hole;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    if (glm::length(cloud.positions[i] - glm::vec3(0.3f, 0.3f, 0.0f)) < 0.08f) continue;
    with_hole.positions.push_back(cloud.positions[i]);
    with_hole.normals.push_back(cloud.normals[i]);
  }
  const SceneFrame scene = stripped(with_hole, 0.01f);
  for (const Corners& corners : triangles_of(scene.strips.indices)) {
    for (std::size_t i = 0; i < 3; ++i) {
      const glm::vec3 edge =
          scene.cloud.positions[corners[i]] - scene.cloud.positions[corners[(i + 1) % 3]];
      ASSERT_LT(glm::length(edge), 0.041f);
    }
  }
}

TEST(Strips, do_not_join_the_two_sides_of_a_thin_sheet) {
  PointCloud cloud = plate(40, 0.01f);
  append(cloud, plate(40, 0.01f, -0.004f, {0, 0, -1}));
  const SceneFrame scene = stripped(cloud, 0.01f);
  const std::vector<Corners> triangles = triangles_of(scene.strips.indices);
  EXPECT_GT(triangles.size(), 2u * 2 * 40 * 40 * 98 / 100);
  const auto side = [&](std::uint32_t i) { return scene.cloud.normals[i].z > 0.0f; };
  for (const auto& [a, b, c] : triangles) {
    ASSERT_EQ(side(a), side(b));
    ASSERT_EQ(side(a), side(c));
  }
}

TEST(Strips, need_no_signs_of_normals) {
  PointCloud cloud = sphere();
  std::mt19937 random(5);
  for (glm::vec3& normal : cloud.normals)
    if (random() % 2 == 0) normal = -normal;
  const SceneFrame scene = stripped(cloud, kSphereRadius, true);
  const std::vector<Corners> triangles = triangles_of(scene.strips.indices);
  EXPECT_NEAR(static_cast<double>(triangles.size()) / static_cast<double>(scene.cloud.size()), 2.0,
              0.03);
}

TEST(Strips, need_no_normals_on_a_plane) {
  PointCloud cloud = plate(30, 0.01f);
  cloud.normals.clear();
  const SceneFrame scene = stripped(cloud, 0.01f, true);
  EXPECT_EQ(triangles_of(scene.strips.indices).size(), 2u * 30 * 30);
}

TEST(Strips, of_too_few_points_are_empty) {
  for (const std::size_t points : {0, 1, 2}) {
    PointCloud cloud = plate(1, 1.0f);
    cloud.positions.resize(points);
    cloud.normals.resize(points);
    EXPECT_TRUE(stripped(cloud, 1.0f).strips.empty()) << points;
  }
  PointCloud line;
  for (int i = 0; i < 100; ++i) {
    line.positions.emplace_back(0.01f * static_cast<float>(i), 0.0f, 0.0f);
    line.normals.emplace_back(0.0f, 0.0f, 1.0f);
  }
  EXPECT_TRUE(stripped(line, 0.01f).strips.empty());
  PointCloud coinciding;
  coinciding.positions.assign(1000, glm::vec3(1.0f));
  coinciding.normals.assign(1000, glm::vec3(0.0f, 0.0f, 1.0f));
  EXPECT_TRUE(stripped(coinciding, 0.01f).strips.empty());
}

TEST(Strips, are_bounded_by_the_spheres_and_cones_of_their_nodes) {
  const SceneFrame scene = stripped(sphere(), kSphereRadius);
  const SurfelStrips& strips = scene.strips;
  for (const StripNode& node : strips.nodes) {
    const auto triangles =
        triangles_of(std::span(strips.indices).subspan(node.first_index, node.indices));
    ASSERT_EQ(triangles.size(), node.triangles);
    for (const auto& [a, b, c] : triangles) {
      const glm::vec3 &p = scene.cloud.positions[a], &q = scene.cloud.positions[b],
                      &r = scene.cloud.positions[c];
      for (const glm::vec3& corner : {p, q, r})
        ASSERT_LE(glm::length(corner - node.center), node.radius * 1.00001f);
      const glm::vec3 normal = glm::normalize(glm::cross(q - p, r - p));
      ASSERT_GE(glm::dot(normal, node.axis), node.cosine);
    }
  }
}

TEST(StripOrder, keeps_each_triangle_once_and_the_way_round_that_it_has) {
  std::mt19937 random(4);
  for (int run = 0; run < 200; ++run) {
    // Parts of a grid, and a few triangles that have nothing to do with others.
    std::vector<Corners> triangles;
    for (std::uint32_t y = 0; y < 6; ++y) {
      for (std::uint32_t x = 0; x < 6; ++x) {
        const std::uint32_t a = 7 * y + x, b = a + 1, c = a + 7, d = a + 8;
        if (random() % 4 != 0) triangles.push_back({a, b, d});
        if (random() % 4 != 0) triangles.push_back({a, d, c});
      }
    }
    triangles.push_back({100, 101, 102});
    std::shuffle(triangles.begin(), triangles.end(), random);
    std::vector<std::uint32_t> indices;
    StripOrder().run(triangles, indices);
    std::vector<Corners> ordered = triangles_of(indices);
    for (auto* all : {&triangles, &ordered}) {
      for (Corners& corners : *all)
        std::rotate(corners.begin(), std::min_element(corners.begin(), corners.end()),
                    corners.end());
      std::sort(all->begin(), all->end());
    }
    ASSERT_EQ(ordered, triangles);
  }
}

TEST(StripOrder, needs_few_indices_for_a_ribbon) {
  std::vector<Corners> ribbon;
  for (std::uint32_t i = 0; i < 40; ++i) {
    ribbon.push_back({i, i + 1, i + 2});
    if (i % 2 == 1) std::swap(ribbon.back()[1], ribbon.back()[2]);
  }
  std::vector<std::uint32_t> indices;
  StripOrder().run(ribbon, indices);
  EXPECT_EQ(indices.size(), 43u);
}

}  // namespace
}  // namespace pointreel::strips_test
