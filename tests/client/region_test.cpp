#include "client/render/region.h"

#include <cmath>

#include <gtest/gtest.h>

#include "client/scene/camera.h"

namespace pointreel::region_test {
namespace {

constexpr glm::ivec2 kSize(400, 300);

glm::mat4 to_clip(const Camera& camera) {
  return camera.projection(4.0 / 3.0) * camera.view_from(glm::dvec3(0.0));
}

Camera front_camera() {
  Camera camera;
  camera.distance = 4.0;
  return camera;
}

TEST(Region, contains_every_sphere_and_little_more) {
  InstanceBounds bounds;
  bounds.grow({0.5f, 0.1f, 0.0f}, 0.05f);
  bounds.grow({0.8f, -0.3f, 0.1f}, 0.02f);
  const glm::mat4 clip = to_clip(front_camera());
  const PixelRect region = region_of(bounds, 2.0f, clip, kSize);
  for (const glm::vec3 p : {glm::vec3(0.5f, 0.1f, 0.0f), glm::vec3(0.8f, -0.3f, 0.1f)}) {
    for (const glm::vec3 to : {glm::vec3(0.1f, 0.0f, 0.0f), glm::vec3(-0.1f, 0.0f, 0.0f),
                               glm::vec3(0.0f, 0.1f, 0.0f), glm::vec3(0.0f, -0.1f, 0.0f)}) {
      const glm::vec4 c = clip * glm::vec4(p + to, 1.0f);
      const glm::vec2 pixel = 0.5f * (glm::vec2(c) / c.w + 1.0f) * glm::vec2(kSize);
      EXPECT_TRUE(glm::all(glm::greaterThanEqual(pixel, glm::vec2(region.min))));
      EXPECT_TRUE(glm::all(glm::lessThanEqual(pixel, glm::vec2(region.max))));
    }
  }
  EXPECT_GT(region.min.x, kSize.x / 2);
  EXPECT_LT(region.max.x, kSize.x * 3 / 4);
}

TEST(Region, is_empty_if_nothing_is_in_view) {
  EXPECT_EQ(region_of({}, 2.0f, to_clip(front_camera()), kSize), PixelRect{});
  InstanceBounds left;
  left.grow({-9.0f, 0.0f, 0.0f}, 0.1f);
  const PixelRect region = region_of(left, 1.0f, to_clip(front_camera()), kSize);
  EXPECT_LE(region.max.x - region.min.x, 1);
}

TEST(Region, is_the_whole_picture_around_the_eye) {
  InstanceBounds around;
  around.grow({0.0f, 0.0f, 3.9f}, 0.2f);
  const PixelRect whole{glm::ivec2(0), kSize};
  EXPECT_EQ(region_of(around, 1.0f, to_clip(front_camera()), kSize), whole);
  around.grow({0.0f, 0.0f, 9.0f}, 0.2f);
  EXPECT_EQ(region_of(around, 1.0f, to_clip(front_camera()), kSize), whole);
}

TEST(Region, grows_by_a_margin_of_pixels_within_the_picture) {
  InstanceBounds bounds;
  bounds.grow({-0.9f, 0.1f, 0.0f}, 0.05f);
  const glm::mat4 clip = to_clip(front_camera());
  const PixelRect close = region_of(bounds, 1.0f, clip, kSize),
                  wide = region_of(bounds, 1.0f, clip, kSize, 7);
  EXPECT_EQ(wide.min, close.min - 7);
  EXPECT_EQ(wide.max, close.max + 7);
  const PixelRect widest = region_of(bounds, 1.0f, clip, kSize, 1000);
  EXPECT_EQ(widest, (PixelRect{glm::ivec2(0), kSize}));
}

TEST(Region, around_two_parts_contains_both) {
  const PixelRect left{{3, 40}, {20, 60}}, right{{15, 2}, {70, 50}};
  EXPECT_EQ(around(left, right), (PixelRect{{3, 2}, {70, 60}}));
  EXPECT_EQ(around(left, {}), left);
  EXPECT_EQ(around({}, right), right);
  EXPECT_TRUE(around({}, {}).empty());
}

TEST(Region, gives_the_size_of_an_instance_in_pixels_at_the_middle) {
  InstanceBounds bounds;
  EXPECT_EQ(radius_in_pixels(bounds, to_clip(front_camera()), kSize), 0.0f);
  bounds.grow({-0.5f, 0.0f, 0.0f}, 0.05f);
  bounds.grow({0.5f, 0.0f, 0.0f}, 0.15f);
  Camera camera = front_camera();
  const double expected = 0.1 / 4.0 / std::tan(0.5 * camera.fov_y) * 0.5 * kSize.y;
  EXPECT_NEAR(radius_in_pixels(bounds, to_clip(camera), kSize), expected, 1e-4 * expected);
  camera.target = {0.0, 0.0, -8.0};  // the instances are behind the eye
  EXPECT_EQ(radius_in_pixels(bounds, to_clip(camera), kSize), 0.0f);
}

}  // namespace
}  // namespace pointreel::region_test
