#include <cmath>
#include <limits>
#include <string>

#include <gtest/gtest.h>

#include "pointreel/cloud.h"
#include "pointreel/geometry.h"

namespace pointreel::point_cloud_test {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinity = std::numeric_limits<float>::infinity();

TEST(Sanitize, drops_points_without_a_finite_position_with_all_their_attributes) {
  PointCloud cloud;
  cloud.positions = {{1, 2, 3}, {kNan, 0, 0}, {0, kInfinity, 0}, {4, 5, 6}};
  cloud.colors = {{1, 1, 1}, {2, 2, 2}, {3, 3, 3}, {4, 4, 4}};
  cloud.normals = {{1, 0, 0}, {0, 1, 0}, {0, 1, 0}, {0, 0, 1}};
  cloud.radii = {1, 1, 1, 2};
  cloud.scalars = {{"class", {5, 6, 7, 8}}};
  const SanitizeReport report = sanitize(cloud);
  EXPECT_EQ(report.dropped_positions, 2u);
  ASSERT_EQ(cloud.size(), 2u);
  EXPECT_EQ(cloud.positions[1], glm::vec3(4, 5, 6));
  EXPECT_EQ(cloud.colors[1], glm::u16vec3(4, 4, 4));
  EXPECT_EQ(cloud.normals[1], glm::vec3(0, 0, 1));
  EXPECT_EQ(cloud.radii[1], 2.0f);
  EXPECT_EQ(cloud.scalars[0].values, (std::vector<float>{5, 8}));
  EXPECT_EQ(bounds(cloud).max, glm::dvec3(4, 5, 6));
}

TEST(Sanitize, marks_zero_and_nan_normals_as_unknown_and_normalises_the_rest) {
  PointCloud cloud;
  cloud.positions.resize(5);
  cloud.normals = {{0, 0, 0}, {kNan, 0, 1}, {0, 3e30f, 0}, {0, 0, 1e-30f}, {kInfinity, 0, 0}};
  EXPECT_EQ(sanitize(cloud).unknown_normals, 3u);
  EXPECT_EQ(cloud.normals[0], glm::vec3(0));
  EXPECT_EQ(cloud.normals[1], glm::vec3(0));
  EXPECT_EQ(cloud.normals[2], glm::vec3(0, 1, 0));
  EXPECT_EQ(cloud.normals[3], glm::vec3(0, 0, 1));
  EXPECT_EQ(cloud.normals[4], glm::vec3(0));
}

TEST(Sanitize, zeroes_unusable_and_huge_radii) {
  PointCloud cloud;
  cloud.positions.resize(200);
  cloud.radii.assign(200, 0.5f);
  cloud.radii[0] = 0.0f;
  cloud.radii[1] = -1.0f;
  cloud.radii[2] = kNan;
  cloud.radii[3] = 1e20f;
  cloud.radii[4] = 2.0f;  // four times the 99th percentile is not beyond it
  EXPECT_EQ(sanitize(cloud).unknown_radii, 4u);
  for (std::size_t i = 0; i < 4; ++i) EXPECT_EQ(cloud.radii[i], 0.0f);
  EXPECT_EQ(cloud.radii[4], 2.0f);
  EXPECT_EQ(cloud.radii[5], 0.5f);
}

TEST(Sanitize, takes_infinite_scalars_for_unknown_and_removes_fields_without_a_known_value) {
  PointCloud cloud;
  cloud.positions.resize(3);
  cloud.scalars = {{"none", {kNan, kInfinity, -kInfinity}}, {"some", {1, kInfinity, kNan}}};
  EXPECT_TRUE(sanitize(cloud).clean());
  ASSERT_EQ(cloud.scalars.size(), 1u);
  EXPECT_EQ(cloud.scalars[0].name, "some");
  EXPECT_EQ(cloud.scalars[0].values[0], 1.0f);
  EXPECT_TRUE(std::isnan(cloud.scalars[0].values[1]));
}

TEST(ScalarName, is_short_and_harmless_text) {
  EXPECT_TRUE(is_scalar_name("scan angle"));
  EXPECT_TRUE(is_scalar_name("Intensit\xc3\xa4t"));
  EXPECT_TRUE(is_scalar_name(std::string(kMaxScalarName, 'a')));
  EXPECT_FALSE(is_scalar_name(""));
  EXPECT_FALSE(is_scalar_name(std::string(kMaxScalarName + 1, 'a')));
  EXPECT_FALSE(is_scalar_name("a\nb"));
  EXPECT_FALSE(is_scalar_name("\xff"));
}

TEST(Sanitize, removes_radii_if_none_is_usable) {
  PointCloud cloud;
  cloud.positions.resize(2);
  cloud.radii = {kNan, -1.0f};
  EXPECT_EQ(sanitize(cloud).unknown_radii, 2u);
  EXPECT_FALSE(cloud.has_radii());
}

TEST(Cube, has_an_edge_of_one_if_the_box_has_no_extent) {
  Box box;
  box.grow(glm::dvec3(7, 8, 9));
  EXPECT_EQ(bounding_cube(box), (Cube{{7, 8, 9}, 1.0}));
  EXPECT_EQ(bounding_cube(Box{}).edge, 1.0);
}

TEST(Cube, takes_the_largest_extent_as_its_edge) {
  Box box;
  box.grow(glm::dvec3(0, 0, 5));
  box.grow(glm::dvec3(0, 3, 5));
  EXPECT_EQ(bounding_cube(box), (Cube{{0, 0, 5}, 3.0}));
}

TEST(VoxelCube, centres_its_cells_on_multiples_of_the_voxel) {
  Box box;
  box.grow(glm::dvec3(-2, 0, 3));
  box.grow(glm::dvec3(5, 1, 3));
  const VoxelCube grid = voxel_cube(box, 1.0);
  EXPECT_EQ(grid.depth, 3);
  EXPECT_EQ(grid.cube, (Cube{{-2.5, -0.5, 2.5}, 8.0}));
}

}  // namespace
}  // namespace pointreel::point_cloud_test
