#include "client/scene/strip_cut.h"

#include <cmath>
#include <limits>
#include <random>
#include <set>
#include <vector>

#include <gtest/gtest.h>

namespace pointreel::strip_cut_test {
namespace {

/// A tree of one patch, with a single triangle that its sphere and its cone barely hold, and with
/// what random choice adds to them.
struct OneTriangle {
  std::array<glm::vec3, 3> corners;
  SurfelStrips strips;
};

OneTriangle random_triangle(std::mt19937& random) {
  std::normal_distribution<float> normal;
  std::uniform_real_distribution<float> unit(0.0f, 1.0f);
  const auto any = [&] { return glm::vec3(normal(random), normal(random), normal(random)); };
  OneTriangle one;
  const float size = std::pow(10.0f, 3.0f * unit(random) - 3.0f);
  for (glm::vec3& corner : one.corners) corner = size * any();
  StripNode node;
  node.indices = 4;
  node.triangles = 1;
  node.center = (one.corners[0] + one.corners[1] + one.corners[2]) / 3.0f;
  for (const glm::vec3& corner : one.corners)
    node.radius = std::max(node.radius, glm::length(corner - node.center) * 1.00001f);
  const glm::vec3 n =
      glm::normalize(glm::cross(one.corners[1] - one.corners[0], one.corners[2] - one.corners[0]));
  // An axis up to 90 degrees away.
  node.axis = glm::normalize(n + unit(random) * glm::normalize(any()));
  node.cosine = glm::dot(n, node.axis) - 1e-5f;
  one.strips.nodes.push_back(node);
  one.strips.indices = {0, 1, 2, kEndOfStrip};
  return one;
}

Camera random_camera(std::mt19937& random) {
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  Camera camera;
  camera.target = glm::dvec3(unit(random), unit(random), unit(random));
  camera.distance = std::pow(10.0, unit(random));
  camera.yaw = 3.1 * unit(random);
  camera.pitch = 1.5 * unit(random);
  return camera;
}

TEST(StripCut, never_takes_a_triangle_that_faces_the_eye_for_a_back) {
  std::mt19937 random(1);
  StripCut cut;
  int away = 0, facing = 0;
  for (int i = 0; i < 1'000'000; ++i) {
    const OneTriangle one = random_triangle(random);
    const Camera camera = random_camera(random);
    cut_strips(one.strips, {.camera = camera, .size = {1280, 720}, .pixel_size = 0.0f}, cut);
    const glm::dvec3 a(one.corners[0]), b(one.corners[1]), c(one.corners[2]);
    const double side = glm::dot(glm::cross(b - a, c - a), camera.eye() - a);
    if (!cut.turned_away.empty()) {
      ++away;
      ASSERT_LT(side, 0.0) << i;
    }
    if (!cut.facing.empty()) {
      ++facing;
      ASSERT_GT(side, 0.0) << i;
    }
  }
  EXPECT_GT(away, 10'000);
  EXPECT_GT(facing, 10'000);
}

TEST(StripCut, never_leaves_out_a_triangle_that_is_in_view) {
  std::mt19937 random(2);
  StripCut cut;
  int out_of_view = 0;
  for (int i = 0; i < 200'000; ++i) {
    const OneTriangle one = random_triangle(random);
    const Camera camera = random_camera(random);
    cut_strips(one.strips, {.camera = camera, .size = {1280, 720}, .pixel_size = 0.0f}, cut);
    if (cut.out_of_view == 0) continue;
    ++out_of_view;
    for (const glm::vec3& corner : one.corners) {
      const glm::dvec3 at = glm::transpose(camera.axes()) * (glm::dvec3(corner) - camera.eye());
      const double slope = std::tan(0.5 * camera.fov_y);
      ASSERT_FALSE(-at.z > 0.0 && std::abs(at.y) < -at.z * slope &&
                   std::abs(at.x) < -at.z * slope * 1280.0 / 720.0)
          << i;
    }
  }
  EXPECT_GT(out_of_view, 10'000);
}

/// A root with two patches of equal size, one at -1 and one at 1 on the x axis.
SurfelStrips two_patches() {
  SurfelStrips strips;
  strips.nodes.resize(3);
  strips.nodes[0] = {.radius = 1.1f, .first_child = 1, .children = 2, .indices = 8, .triangles = 2};
  for (std::uint32_t i = 0; i < 2; ++i) {
    StripNode& node = strips.nodes[i + 1];
    node.center.x = i == 0 ? -1.0f : 1.0f;
    node.radius = 0.1f;
    node.first_index = 4 * i;
    node.indices = 4;
    node.triangles = 1;
  }
  strips.indices = {0, 1, 2, kEndOfStrip, 3, 4, 5, kEndOfStrip};
  return strips;
}

TEST(StripCut, joins_patches_that_follow_each_other) {
  StripCut cut;
  cut_strips(two_patches(), {.camera = {.distance = 5.0}, .size = {640, 480}}, cut);
  ASSERT_EQ(cut.mixed.size(), 1u);
  EXPECT_EQ(cut.mixed[0].first, 0u);
  EXPECT_EQ(cut.mixed[0].count, 8u);
  EXPECT_EQ(cut.triangles, 2u);
}

TEST(StripCut, draws_nodes_as_points_where_they_are_smaller_than_a_pixel) {
  StripCut cut;
  const StripView view{.camera = {.distance = 200.0}, .size = {640, 480}};
  cut_strips(two_patches(), view, cut);
  EXPECT_EQ(cut.points, (std::vector<std::uint32_t>{1, 2}));
  EXPECT_EQ(cut.below_pixel, 2u);
  StripView farther = view;
  farther.camera.distance = 2000.0;
  cut_strips(two_patches(), farther, cut);
  EXPECT_EQ(cut.points, (std::vector<std::uint32_t>{0}));
  farther.pixel_size = 0.0f;
  cut_strips(two_patches(), farther, cut);
  EXPECT_TRUE(cut.points.empty());
}

TEST(StripCut, leaves_out_what_is_beside_the_picture) {
  StripCut cut;
  cut_strips(two_patches(),
             {.camera = {.target = glm::dvec3(1.0, 0.0, 0.0), .distance = 1.0}, .size = {480, 480}},
             cut);
  EXPECT_EQ(cut.out_of_view, 1u);
  ASSERT_EQ(cut.mixed.size(), 1u);
  EXPECT_EQ(cut.mixed[0].first, 4u);
}

TEST(StripCut, of_nothing_is_empty) {
  StripCut cut;
  cut_strips({}, {}, cut);
  EXPECT_EQ(cut.visited, 0u);
  EXPECT_TRUE(cut.mixed.empty());
}

}  // namespace
}  // namespace pointreel::strip_cut_test
