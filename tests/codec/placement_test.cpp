#include "codec/core/placement.h"

#include <gtest/gtest.h>

#include "codec/cloud_options/cloud_options.h"

namespace pointreel::placement_test {
namespace {

void expect_near(const glm::dvec3& a, const glm::dvec3& b) {
  EXPECT_LT(glm::length(a - b), 1e-9) << a.x << " " << a.y << " " << a.z;
}

TEST(Placement, rotations_turn_about_fixed_axes_x_first) {
  expect_near(rotation_of({90, 0, 0}) * glm::dvec3(0, 1, 0), {0, 0, 1});
  expect_near(rotation_of({0, 90, 0}) * glm::dvec3(0, 0, 1), {1, 0, 0});
  expect_near(rotation_of({0, 0, 90}) * glm::dvec3(1, 0, 0), {0, 1, 0});
  expect_near(rotation_of({90, 0, 90}) * glm::dvec3(0, 1, 0), {0, 0, 1});
  expect_near(rotation_of({0, 0, 30}) * glm::dvec3(1, 0, 0), {std::sqrt(0.75), 0.5, 0});
  expect_near(rotation_of({-90, 0, 0}) * glm::dvec3(0, 0, 1), {0, 1, 0});
}

TEST(Placement, right_angles_are_exact) {
  EXPECT_EQ(rotation_of({-90, 180, 270}) * rotation_of({0, 0, 0}) * glm::dvec3(0.1, 0.2, 0.3),
            rotation_of({270, -180, -90}) * glm::dvec3(0.1, 0.2, 0.3));
  EXPECT_EQ(rotation_of({360, 0, -360}), glm::dmat3(1.0));
}

TEST(Placement, points_normals_and_radii_move_together) {
  PointCloud cloud;
  cloud.origin = {100, 200, 300};
  cloud.positions = {{1, 2, 3}};
  cloud.normals = {{0, 0, 1}};
  cloud.radii = {0.5f};
  place(cloud, {2.0, rotation_of({-90, 0, 0})});
  expect_near(cloud.world(0), {202, 606, -404});
  EXPECT_EQ(cloud.normals[0], glm::vec3(0, 1, 0));
  EXPECT_EQ(cloud.radii[0], 1.0f);
}

TEST(Placement, degrees_are_three_numbers) {
  EXPECT_EQ(parse_degrees("-90,0,12.5").value(), glm::dvec3(-90, 0, 12.5));
  for (const char* bad : {"", "1,2", "1,2,3,4", "1;2;3", "a,2,3", "1,2,nan", "1,2,361", "1,2,3 "})
    EXPECT_FALSE(parse_degrees(bad)) << bad;
}

}  // namespace
}  // namespace pointreel::placement_test
