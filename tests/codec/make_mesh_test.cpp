#include "codec/mesh/make_mesh.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <numbers>
#include <random>
#include <set>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "common/threads/tbb_executor.h"

namespace pointreel::make_mesh_test {
namespace {

constexpr double kPi = std::numbers::pi;

PointCloud sphere(std::size_t count, double radius = 1.0, glm::dvec3 center = glm::dvec3(0.0)) {
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  PointCloud cloud;
  for (std::size_t i = 0; i < count; ++i) {
    const glm::dvec3 n = glm::normalize(glm::dvec3(normal(random), normal(random), normal(random)));
    cloud.positions.emplace_back(center + radius * n);
    cloud.normals.emplace_back(n);
  }
  return cloud;
}

constexpr double kMajor = 1.0, kMinor = 0.35;

PointCloud torus(std::size_t count) {
  std::mt19937 random(2);
  std::uniform_real_distribution<double> turn(0.0, 2.0 * kPi), share(0.0, 1.0);
  PointCloud cloud;
  while (cloud.size() < count) {
    const double u = turn(random), v = turn(random);
    if (share(random) > (kMajor + kMinor * std::cos(v)) / (kMajor + kMinor)) continue;
    const glm::dvec3 out(std::cos(u), std::sin(u), 0.0);
    const glm::dvec3 n = std::cos(v) * out + std::sin(v) * glm::dvec3(0.0, 0.0, 1.0);
    cloud.positions.emplace_back(kMajor * out + kMinor * n);
    cloud.normals.emplace_back(n);
  }
  return cloud;
}

/// The square from 0 to 1 in the plane z = 0, without what `without` says.
PointCloud square(std::size_t count, const std::function<bool(double, double)>& without = {}) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> share(0.0, 1.0);
  PointCloud cloud;
  for (std::size_t i = 0; i < count; ++i) {
    const double x = share(random), y = share(random);
    if (without && without(x, y)) continue;
    cloud.positions.emplace_back(x, y, 0.0);
    cloud.normals.emplace_back(0.0f, 0.0f, 1.0f);
  }
  return cloud;
}

double torus_distance(const glm::dvec3& p) {
  return std::hypot(std::hypot(p.x, p.y) - kMajor, p.z) - kMinor;
}

glm::dvec3 position(const TriangleMesh& mesh, std::uint32_t vertex) {
  return glm::dvec3(mesh.vertices.positions[vertex]);
}

TriangleMesh mesh_of(const PointCloud& cloud, const MeshOptions& options = {},
                     const Executor& executor = {}) {
  Result<TriangleMesh> mesh = make_mesh(cloud, options, executor);
  EXPECT_TRUE(mesh);
  return mesh ? std::move(*mesh) : TriangleMesh{};
}

/// How triangles hang together.
struct Shape {
  int euler = 0;         ///< vertices - edges + triangles
  int boundary = 0;      ///< edges with one triangle
  bool manifold = true;  ///< no edge has two triangles in the same direction
  int parts = 0;
  int degenerate = 0, turned = 0;  ///< triangles without area; triangles that face inward
  double longest = 0.0;            ///< edge
};

Shape shape_of(const TriangleMesh& mesh) {
  Shape shape;
  std::set<std::pair<std::uint32_t, std::uint32_t>> directed;
  std::vector<std::uint32_t> part(mesh.vertices.size());
  for (std::uint32_t i = 0; i < part.size(); ++i) part[i] = i;
  const std::function<std::uint32_t(std::uint32_t)> root = [&](std::uint32_t i) {
    while (part[i] != i) i = part[i] = part[part[i]];
    return i;
  };
  for (const glm::uvec3& t : mesh.triangles) {
    for (int i = 0; i < 3; ++i) {
      const std::uint32_t a = t[i], b = t[(i + 1) % 3];
      if (!directed.emplace(a, b).second) shape.manifold = false;
      part[root(a)] = root(b);
      shape.longest = std::max(shape.longest, glm::distance(position(mesh, a), position(mesh, b)));
    }
    const glm::dvec3 normal = glm::cross(position(mesh, t.y) - position(mesh, t.x),
                                         position(mesh, t.z) - position(mesh, t.x));
    if (!(glm::length(normal) > 0.0)) ++shape.degenerate;
    if (!(glm::dot(normal, glm::dvec3(mesh.vertices.normals[t.x])) > 0.0)) ++shape.turned;
  }
  int edges = 0;
  for (const auto& [a, b] : directed) {
    const bool has_other = directed.count({b, a}) > 0;
    if (!has_other) ++shape.boundary;
    if (!has_other || a < b) ++edges;
  }
  for (std::uint32_t i = 0; i < part.size(); ++i) shape.parts += root(i) == i ? 1 : 0;
  shape.euler =
      static_cast<int>(mesh.vertices.size()) - edges + static_cast<int>(mesh.triangles.size());
  return shape;
}

/// The largest distance of vertices and of the middles of triangles from a surface.
double largest_error(const TriangleMesh& mesh,
                     const std::function<double(const glm::dvec3&)>& distance) {
  double largest = 0.0;
  for (const glm::uvec3& t : mesh.triangles) {
    const glm::dvec3 a = position(mesh, t.x), b = position(mesh, t.y), c = position(mesh, t.z);
    for (const glm::dvec3& p : {a, b, c, (a + b + c) / 3.0})
      largest = std::max(largest, std::abs(distance(p)));
  }
  return largest;
}

double sphere_distance(const glm::dvec3& p) { return glm::length(p) - 1.0; }

TEST(MakeMesh, makes_a_closed_surface_of_a_sphere) {
  const TriangleMesh mesh = mesh_of(sphere(20000));
  const Shape shape = shape_of(mesh);
  EXPECT_GT(mesh.triangles.size(), 10000u);
  EXPECT_EQ(shape.euler, 2);
  EXPECT_EQ(shape.boundary, 0);
  EXPECT_EQ(shape.parts, 1);
  EXPECT_TRUE(shape.manifold);
  EXPECT_EQ(shape.degenerate, 0);
  EXPECT_EQ(shape.turned, 0);
  EXPECT_LT(largest_error(mesh, sphere_distance), 1e-3);
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    const glm::vec3 outward = glm::normalize(mesh.vertices.positions[i]);
    ASSERT_GT(glm::dot(mesh.vertices.normals[i], outward), 0.999f);
  }
}

TEST(MakeMesh, makes_a_closed_surface_of_a_torus) {
  const TriangleMesh mesh = mesh_of(torus(30000));
  const Shape shape = shape_of(mesh);
  EXPECT_EQ(shape.euler, 0);
  EXPECT_EQ(shape.boundary, 0);
  EXPECT_EQ(shape.parts, 1);
  EXPECT_TRUE(shape.manifold);
  EXPECT_EQ(shape.turned, 0);
  EXPECT_LT(largest_error(mesh, torus_distance), 2e-3);
}

TEST(MakeMesh, estimates_normals_where_there_are_none) {
  PointCloud cloud = torus(30000);
  cloud.normals.clear();
  const TriangleMesh mesh = mesh_of(cloud);
  EXPECT_EQ(shape_of(mesh).euler, 0);
  EXPECT_LT(largest_error(mesh, torus_distance), 5e-3);
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    const glm::dvec3 p(mesh.vertices.positions[i]);
    ASSERT_GT(torus_distance(p + 0.01 * glm::dvec3(mesh.vertices.normals[i])), 0.0);
  }
}

TEST(MakeMesh, averages_the_noise_of_points) {
  PointCloud cloud = sphere(20000);
  std::mt19937 random(4);
  std::normal_distribution<float> noise(0.0f, 0.01f);
  double sum = 0.0, mesh_sum = 0.0;
  for (glm::vec3& p : cloud.positions) {
    p *= 1.0f + noise(random);
    sum += std::abs(sphere_distance(glm::dvec3(p)));
  }
  const TriangleMesh mesh = mesh_of(cloud);
  for (const glm::vec3& p : mesh.vertices.positions)
    mesh_sum += std::abs(sphere_distance(glm::dvec3(p)));
  EXPECT_LT(mesh_sum / static_cast<double>(mesh.vertices.size()),
            0.5 * sum / static_cast<double>(cloud.size()));
}

TEST(MakeMesh, ends_near_the_boundary_of_a_plane) {
  const TriangleMesh mesh = mesh_of(square(20000));
  const Shape shape = shape_of(mesh);
  EXPECT_EQ(shape.euler, 1) << "a disc without holes";
  EXPECT_EQ(shape.parts, 1);
  EXPECT_EQ(shape.turned, 0);
  const float spacing = 1.0f / std::sqrt(20000.0f);
  double area = 0.0;
  for (const glm::vec3& p : mesh.vertices.positions) {
    EXPECT_NEAR(p.z, 0.0f, 1e-5f);
    for (const float x : {p.x, p.y}) {
      EXPECT_GT(x, -2.0f * spacing);
      EXPECT_LT(x, 1.0f + 2.0f * spacing);
    }
  }
  for (const glm::uvec3& t : mesh.triangles) {
    area += 0.5 * glm::length(glm::cross(position(mesh, t.y) - position(mesh, t.x),
                                         position(mesh, t.z) - position(mesh, t.x)));
  }
  EXPECT_NEAR(area, 1.0, 0.02);
}

TEST(MakeMesh, leaves_large_holes_open_and_closes_small_gaps) {
  const auto round = [](double radius) {
    return [radius](double x, double y) { return std::hypot(x - 0.5, y - 0.5) < radius; };
  };
  const double spacing = 1.0 / std::sqrt(20000.0);
  EXPECT_EQ(shape_of(mesh_of(square(20000, round(20.0 * spacing)))).euler, 0);
  EXPECT_EQ(shape_of(mesh_of(square(20000, round(1.2 * spacing)))).euler, 1);
}

TEST(MakeMesh, keeps_two_sheets_apart) {
  PointCloud cloud = square(20000);
  const PointCloud front = cloud;
  for (std::size_t i = 0; i < front.size(); ++i) {
    cloud.positions.push_back(front.positions[i] - glm::vec3(0.0f, 0.0f, 0.03f));
    cloud.normals.emplace_back(0.0f, 0.0f, -1.0f);
  }
  const TriangleMesh mesh = mesh_of(cloud);
  const Shape shape = shape_of(mesh);
  EXPECT_TRUE(shape.manifold);
  EXPECT_EQ(shape.turned, 0);
  for (const glm::vec3& p : mesh.vertices.positions) {
    const bool inner = p.x > 0.05f && p.x < 0.95f && p.y > 0.05f && p.y < 0.95f;
    const float nearest = std::min(std::abs(p.z), std::abs(p.z + 0.03f));
    ASSERT_LT(inner ? nearest : 0.0f, 1e-3f);
  }
}

TEST(MakeMesh, has_no_long_edges_whatever_the_points) {
  PointCloud cloud = sphere(20000);
  std::erase_if(cloud.positions, [](const glm::vec3& p) { return p.z > 0.3f && p.z < 0.6f; });
  cloud.normals.clear();
  EXPECT_LT(shape_of(mesh_of(cloud)).longest, 6.0 * kCellSpacings * std::sqrt(4.0 * kPi / 20000));
}

TEST(MakeMesh, makes_parts_of_things_far_from_each_other) {
  PointCloud cloud = sphere(5000);
  const PointCloud other = sphere(5000, 1.0, glm::dvec3(300.0, -40.0, 0.0));
  cloud.positions.insert(cloud.positions.end(), other.positions.begin(), other.positions.end());
  cloud.normals.insert(cloud.normals.end(), other.normals.begin(), other.normals.end());
  const Shape shape = shape_of(mesh_of(cloud));
  EXPECT_EQ(shape.parts, 2);
  EXPECT_EQ(shape.euler, 4);
}

TEST(MakeMesh, leaves_out_stray_points) {
  PointCloud cloud = sphere(5000);
  const std::vector<glm::vec3> strays = {
      {2.0f, 0.0f, 0.0f}, {0.0f, -3.0f, 0.0f}, {0.0f, -3.0f, 0.01f}};
  for (const glm::vec3& stray : strays) {
    cloud.positions.push_back(stray);
    cloud.normals.push_back(glm::normalize(stray));
  }
  const TriangleMesh mesh = mesh_of(cloud);
  EXPECT_EQ(shape_of(mesh).parts, 1);
  EXPECT_LT(largest_error(mesh, sphere_distance), 5e-3);
}

TEST(MakeMesh, makes_nothing_of_too_few_points) {
  EXPECT_TRUE(mesh_of({}).empty());
  for (const std::size_t count : {1, 2, 3}) {
    const TriangleMesh mesh = mesh_of(sphere(count));
    EXPECT_TRUE(mesh.empty()) << count;
    EXPECT_TRUE(mesh.vertices.empty()) << count;
  }
  PointCloud same;
  same.positions.assign(1000, glm::vec3(1.0f));
  EXPECT_TRUE(mesh_of(same).empty());
  PointCloud line;
  for (int i = 0; i < 1000; ++i) line.positions.emplace_back(i, 0.0f, 0.0f);
  EXPECT_TRUE(mesh_of(line).empty());
}

TEST(MakeMesh, makes_a_surface_of_sparse_points) {
  const TriangleMesh mesh = mesh_of(sphere(300));
  EXPECT_EQ(shape_of(mesh).parts, 1);
  EXPECT_LT(largest_error(mesh, sphere_distance), 0.1);
}

TEST(MakeMesh, reduces_to_the_triangles_that_are_asked_for) {
  const TriangleMesh mesh = mesh_of(torus(30000), {.triangles = 2000});
  EXPECT_LE(mesh.triangles.size(), 2000u);
  EXPECT_GT(mesh.triangles.size(), 1900u);
  const Shape shape = shape_of(mesh);
  EXPECT_EQ(shape.euler, 0);
  EXPECT_EQ(shape.boundary, 0);
  EXPECT_EQ(shape.degenerate, 0);
  EXPECT_LT(largest_error(mesh, torus_distance), 0.02);
  EXPECT_EQ(mesh.vertices.normals.size(), mesh.vertices.size());
}

TEST(MakeMesh, takes_the_cell_that_is_asked_for) {
  const TriangleMesh coarse = mesh_of(sphere(20000), {.cell = 0.1});
  const TriangleMesh fine = mesh_of(sphere(20000), {.cell = 0.05});
  EXPECT_EQ(shape_of(coarse).euler, 2);
  EXPECT_NEAR(
      static_cast<double>(fine.triangles.size()) / static_cast<double>(coarse.triangles.size()),
      4.0, 0.5);
}

TEST(MakeMesh, gives_vertices_the_colours_of_the_points_there) {
  PointCloud cloud = square(20000);
  for (const glm::vec3& p : cloud.positions)
    cloud.colors.push_back(p.x < 0.5f ? glm::u16vec3(65535, 0, 0) : glm::u16vec3(0, 0, 65535));
  const TriangleMesh mesh = mesh_of(cloud);
  ASSERT_EQ(mesh.vertices.colors.size(), mesh.vertices.size());
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    const float x = mesh.vertices.positions[i].x;
    const glm::u16vec3& color = mesh.vertices.colors[i];
    EXPECT_NEAR(int{color.x} + int{color.z}, 65535, 2);
    EXPECT_GT(x < 0.46f ? color.x : 65535, 60000);
    EXPECT_GT(x > 0.54f ? color.z : 65535, 60000);
  }
}

TEST(MakeMesh, keeps_the_origin_of_clouds_far_away) {
  PointCloud cloud = sphere(5000);
  const TriangleMesh near = mesh_of(cloud);
  cloud.origin = glm::dvec3(4.5e6, -1.0e6, 300.0);
  const TriangleMesh far = mesh_of(cloud);
  EXPECT_EQ(far.vertices.origin, cloud.origin);
  EXPECT_EQ(shape_of(far).euler, 2);
  EXPECT_NEAR(static_cast<double>(far.triangles.size()), static_cast<double>(near.triangles.size()),
              0.02 * static_cast<double>(near.triangles.size()));
}

TEST(MakeMesh, takes_no_more_memory_than_it_may) {
  PointCloud cloud = sphere(1000, 1e-3);
  // Points far from each other, which share no cells.
  const PointCloud strays = sphere(900, 1e3);
  cloud.positions.insert(cloud.positions.end(), strays.positions.begin(), strays.positions.end());
  cloud.normals.insert(cloud.normals.end(), strays.normals.begin(), strays.normals.end());
  EXPECT_TRUE(make_mesh(sphere(1000), {.max_memory = 1 << 20}));
  const Result<TriangleMesh> mesh = make_mesh(cloud, {.max_memory = 1 << 20});
  ASSERT_FALSE(mesh);
  EXPECT_EQ(mesh.error().code, ErrorCode::limit);
}

TEST(MakeMesh, does_not_depend_on_the_executor) {
  const PointCloud cloud = torus(100000);
  const TriangleMesh one = mesh_of(cloud), all = mesh_of(cloud, {}, tbb_executor());
  EXPECT_EQ(one.triangles, all.triangles);
  EXPECT_EQ(one.vertices.positions, all.vertices.positions);
}

}  // namespace
}  // namespace pointreel::make_mesh_test
