#include "client/scene/camera.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

namespace pointreel {
namespace {

constexpr double kAspect = 16.0 / 9.0;

glm::dvec3 corner(const Box& box, int i) {
  return {i & 1 ? box.max.x : box.min.x, i & 2 ? box.max.y : box.min.y,
          i & 4 ? box.max.z : box.min.z};
}

/// Normalised device coordinates of a world point, with everything in double.
glm::dvec3 project(const Camera& camera, const glm::dvec3& world, double aspect) {
  const glm::dvec3 e = glm::transpose(camera.axes()) * (world - camera.eye());
  const double t = std::tan(0.5 * camera.fov_y);
  return {e.x / (-e.z * t * aspect), e.y / (-e.z * t), camera.near_plane() / -e.z};
}

glm::vec3 device(const Camera& camera, const glm::vec3& local, const glm::dvec3& origin) {
  const glm::vec4 clip =
      camera.projection(kAspect) * camera.view_from(origin) * glm::vec4(local, 1.0f);
  return glm::vec3(clip) / clip.w;
}

TEST(Camera, TheFrontViewOfAYUpWorldLooksAlongMinusZWithXToTheRight) {
  Camera camera;
  const glm::dmat3 axes = camera.axes();
  EXPECT_NEAR(glm::length(axes[0] - glm::dvec3(1, 0, 0)), 0.0, 1e-15);
  EXPECT_NEAR(glm::length(axes[1] - glm::dvec3(0, 1, 0)), 0.0, 1e-15);
  EXPECT_NEAR(glm::length(axes[2] - glm::dvec3(0, 0, 1)), 0.0, 1e-15);
}

TEST(Camera, TheFrontViewOfAZUpWorldLooksAlongPlusYWithXToTheRight) {
  Camera camera;
  camera.up = 'z';
  const glm::dmat3 axes = camera.axes();
  EXPECT_NEAR(glm::length(axes[0] - glm::dvec3(1, 0, 0)), 0.0, 1e-15);
  EXPECT_NEAR(glm::length(axes[1] - glm::dvec3(0, 0, 1)), 0.0, 1e-15);
  EXPECT_NEAR(glm::length(axes[2] - glm::dvec3(0, -1, 0)), 0.0, 1e-15);
}

TEST(Camera, PositiveYawMovesTheEyeToTheRightAndPositivePitchAbove) {
  for (const char up : {'y', 'z'}) {
    Camera camera;
    camera.up = up;
    camera.orbit(0.5, 0.25);
    const glm::dvec3 eye = camera.eye();
    EXPECT_GT(eye.x, 0.0);
    EXPECT_NEAR(up == 'y' ? eye.y : eye.z, 3.0 * std::sin(0.25), 1e-12);
    const glm::dmat3 axes = camera.axes();
    EXPECT_NEAR(glm::determinant(axes), 1.0, 1e-12);
    EXPECT_NEAR(glm::length(glm::cross(axes[0], axes[1]) - axes[2]), 0.0, 1e-12);
  }
}

TEST(Camera, FramedBoundsAreWhollyVisibleAndFillMostOfThePicture) {
  for (const char up : {'y', 'z'}) {
    for (const double aspect : {0.4, 1.0, kAspect, 4.0}) {
      for (const Box& box : {Box{{-1, -2, -3}, {4, 5, 6}}, Box{{5, 5, 5}, {5, 9, 5}},
                             Box{{1e6, 2e6, 3e6}, {1e6 + 1, 2e6 + 2, 3e6 + 0.5}}}) {
        Camera camera;
        camera.up = up;
        camera.frame_bounds(box, aspect);
        double widest = 0.0;
        for (int i = 0; i < 8; ++i) {
          const glm::dvec3 p = project(camera, corner(box, i), aspect);
          EXPECT_GT(p.z, 0.0);
          EXPECT_LT(p.z, 1.0);
          widest = std::max({widest, std::abs(p.x), std::abs(p.y)});
        }
        EXPECT_LT(widest, 0.95);
        EXPECT_GT(widest, 0.85);
        EXPECT_GT(up == 'y' ? camera.eye().y : camera.eye().z,
                  up == 'y' ? camera.target.y : camera.target.z);
      }
    }
  }
}

TEST(Camera, BoundsWithoutExtentGiveAFiniteView) {
  for (const Box& box : {Box{}, Box{{1, 2, 3}, {1, 2, 3}}}) {
    Camera camera;
    camera.frame_bounds(box, kAspect);
    EXPECT_GT(camera.distance, 0.5);
    EXPECT_LT(camera.distance, 10.0);
    EXPECT_GT(camera.near_plane(), 0.0);
  }
}

TEST(Camera, AnOffsetOfAMillionDoesNotMoveAPointInThePicture) {
  Camera here;
  here.frame_bounds({{-1, -1, -1}, {1, 1, 1}}, kAspect);
  here.orbit(0.7, 0.2);
  Camera there = here;
  const glm::dvec3 offset(1e6, -3e6, 7e6);
  there.target += offset;
  const glm::vec3 p(0.3f, -0.8f, 0.5f);
  const glm::vec3 a = device(here, p, glm::dvec3(0.0)), b = device(there, p, offset);
  EXPECT_NEAR(a.x, b.x, 1e-6);
  EXPECT_NEAR(a.y, b.y, 1e-6);
  const glm::dvec3 exact = project(there, offset + glm::dvec3(p), kAspect);
  EXPECT_NEAR(b.x, exact.x, 1e-6);
  EXPECT_NEAR(b.y, exact.y, 1e-6);
  EXPECT_NEAR(b.z, exact.z, 1e-8);
}

TEST(Camera, DepthIsOneAtTheNearPlaneAndTellsApartAHundredThousandTimesFurther) {
  Camera camera;
  const glm::mat4 p = camera.projection(1.0);
  const auto depth = [&](double z) {
    const glm::vec4 clip = p * glm::vec4(0.0f, 0.0f, static_cast<float>(-z), 1.0f);
    return clip.z / clip.w;
  };
  const double near = camera.near_plane();
  EXPECT_NEAR(depth(near), 1.0, 1e-6);
  EXPECT_GT(depth(1e5 * near), 0.0f);
  EXPECT_GT(depth(1e5 * near), depth(1.00001e5 * near));
}

TEST(Camera, ZoomStaysWithinTheSceneAndPitchShortOfThePoles) {
  Camera camera;
  for (int i = 0; i < 1000; ++i) camera.zoom(0.5);
  EXPECT_GT(camera.distance, 0.0);
  for (int i = 0; i < 1000; ++i) camera.zoom(2.0);
  EXPECT_LE(camera.distance, 1e3 * camera.scene_radius);
  camera.orbit(0.0, 100.0);
  EXPECT_LT(camera.pitch, 1.5707);
}

TEST(Camera, PanMovesThePictureByTheGivenShareOfItsHeight) {
  Camera camera;
  camera.orbit(0.4, 0.3);
  const glm::dvec3 point = camera.target;
  camera.pan(0.25, -0.125);
  const glm::dvec3 p = project(camera, point, 1.0);
  EXPECT_NEAR(p.x, -0.5, 1e-12);
  EXPECT_NEAR(p.y, 0.25, 1e-12);
}

}  // namespace
}  // namespace pointreel
