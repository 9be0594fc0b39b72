#include "datasets_synthetic/texture.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <tuple>

#include <gtest/gtest.h>

#include "datasets_synthetic/body.h"
#include "datasets_synthetic/motion.h"
#include "datasets_synthetic/random.h"
#include "datasets_synthetic/samplers/uniform.h"

namespace pointreel::texture_test {
namespace {

TEST(Texture, noise_fills_its_range_smoothly_and_has_no_direction) {
  Random random(1, 0);
  double lowest = 1.0, highest = -1.0, sum = 0.0;
  for (int i = 0; i < 4000; ++i) {
    const double x = random.uniform(), y = random.uniform(), z = random.uniform();
    const glm::dvec3 p = 60.0 * glm::dvec3(x, y, z) - 30.0;
    const double value = value_noise(p, 7);
    lowest = std::min(lowest, value);
    highest = std::max(highest, value);
    sum += value;
    for (int axis = 0; axis < 3; ++axis) {
      glm::dvec3 step(0.0);
      step[axis] = 1e-4;
      EXPECT_LT(std::abs(value_noise(p + step, 7) - value), 4e-4);
    }
  }
  EXPECT_GE(lowest, -1.0);
  EXPECT_LE(highest, 1.0);
  EXPECT_LT(lowest, -0.7);
  EXPECT_GT(highest, 0.7);
  EXPECT_NEAR(sum / 4000.0, 0.0, 0.03);
}

TEST(Texture, noise_is_continuous_at_grid_corners_and_differs_by_seed) {
  for (const glm::dvec3& corner :
       {glm::dvec3(0, 0, 0), glm::dvec3(-3, 5, 2), glm::dvec3(4, -1, -9)}) {
    const double value = value_noise(corner, 3);
    EXPECT_NE(value, value_noise(corner, 4));
    EXPECT_NE(value, value_noise(corner + glm::dvec3(1, 0, 0), 3));
    EXPECT_NEAR(value_noise(corner + 1e-9, 3), value, 1e-8);
    EXPECT_NEAR(value_noise(corner - 1e-9, 3), value, 1e-8);
  }
}

TEST(Texture, threads_of_a_weave_alternate_over_and_under) {
  EXPECT_GT(weave({0.003, 0.003, 0.0}, 0.006), 0.9);
  EXPECT_LT(weave({0.009, 0.003, 0.0}, 0.006), -0.9);
  EXPECT_GT(weave({0.009, 0.009, 0.0}, 0.006), 0.9);
  EXPECT_NEAR(weave({0.006, 0.003, 0.0}, 0.006), 0.0, 1e-9);
}

TEST(Texture, shading_keeps_the_hue_and_stays_in_range) {
  EXPECT_EQ(shaded({100, 50, 200}, 0.0), glm::u8vec3(100, 50, 200));
  EXPECT_EQ(shaded({100, 50, 200}, 0.1), glm::u8vec3(110, 55, 220));
  EXPECT_EQ(shaded({100, 50, 250}, 0.5), glm::u8vec3(150, 75, 255));
  EXPECT_EQ(shaded({100, 50, 250}, -2.0), glm::u8vec3(0, 0, 0));
}

TEST(Texture, a_person_has_as_many_colours_as_a_photograph_and_they_move_with_the_body) {
  const Body body = pose_body(walk(0.4)), moved = pose_body(walk(1.1));
  std::set<std::tuple<int, int, int>> colours;
  const auto points = sample_uniform(body.surface, 4000, 3);
  for (const SurfacePoint& point : points.value()) {
    const glm::u8vec3 c = color_at(body, point.primitive, point.position);
    colours.emplace(c.x, c.y, c.z);
    const Frame& frame = moved.frames[static_cast<std::size_t>(moved.parts[point.primitive].bone)];
    const glm::dvec3 elsewhere = frame.place(body.in_rest(point.primitive, point.position));
    const glm::dvec3 difference =
        glm::dvec3(color_at(moved, point.primitive, elsewhere)) - glm::dvec3(c);
    EXPECT_LE(std::abs(difference.x), 1.0);  // rounding only
  }
  EXPECT_GT(colours.size(), 450u);
}

}  // namespace
}  // namespace pointreel::texture_test
