#include "client/scene/camera.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

namespace pointreel::camera_test {
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

TEST(Camera, front_view_of_a_y_up_world_looks_along_minus_z_with_x_to_the_right) {
  Camera camera;
  const glm::dmat3 axes = camera.axes();
  EXPECT_NEAR(glm::length(axes[0] - glm::dvec3(1, 0, 0)), 0.0, 1e-15);
  EXPECT_NEAR(glm::length(axes[1] - glm::dvec3(0, 1, 0)), 0.0, 1e-15);
  EXPECT_NEAR(glm::length(axes[2] - glm::dvec3(0, 0, 1)), 0.0, 1e-15);
}

TEST(Camera, front_view_of_a_z_up_world_looks_along_plus_y_with_x_to_the_right) {
  Camera camera;
  camera.up = 'z';
  const glm::dmat3 axes = camera.axes();
  EXPECT_NEAR(glm::length(axes[0] - glm::dvec3(1, 0, 0)), 0.0, 1e-15);
  EXPECT_NEAR(glm::length(axes[1] - glm::dvec3(0, 0, 1)), 0.0, 1e-15);
  EXPECT_NEAR(glm::length(axes[2] - glm::dvec3(0, -1, 0)), 0.0, 1e-15);
}

TEST(Camera, every_axis_can_point_up_in_either_direction) {
  for (const char letter : {'x', 'y', 'z'}) {
    for (const bool reversed : {false, true}) {
      Camera camera;
      camera.up = Up(letter, reversed);
      const glm::dmat3 axes = camera.axes();
      EXPECT_NEAR(glm::length(axes[1] - camera.up.direction()), 0.0, 1e-15) << camera.up.text();
      EXPECT_NEAR(glm::determinant(axes), 1.0, 1e-15) << camera.up.text();
      EXPECT_EQ(parse_up(camera.up.text()), camera.up);
      camera.orbit(0.0, 0.25);
      EXPECT_NEAR(glm::dot(camera.eye(), camera.up.direction()), 3.0 * std::sin(0.25), 1e-12);
      const glm::dvec3 before = camera.eye();
      camera.fly({0.0, 1.0, 0.0}, 0.0, 0.0);
      EXPECT_NEAR(glm::length(camera.eye() - before - camera.up.direction()), 0.0, 1e-12);
    }
  }
  for (const char* text : {"", "-", "w", "yy", "--y", "+y", "Y"}) EXPECT_FALSE(parse_up(text));
}

TEST(Camera, positive_yaw_moves_the_eye_right_and_positive_pitch_moves_it_up) {
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

TEST(Camera, framed_bounds_are_fully_visible_and_fill_most_of_the_picture) {
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
        EXPECT_LT(widest, 0.98);
        EXPECT_GT(widest, 0.95);
        EXPECT_GT(up == 'y' ? camera.eye().y : camera.eye().z,
                  up == 'y' ? camera.target.y : camera.target.z);
      }
    }
  }
}

TEST(Camera, a_box_fits_from_every_direction_and_above_what_is_covered) {
  const Box box{{-1, 0, -0.3}, {1, 3, 0.3}};
  for (const double covered : {0.0, 0.15, 0.3}) {
    for (double yaw = -3.0; yaw < 3.2; yaw += 0.5) {
      for (double pitch = -1.5; pitch < 1.6; pitch += 0.5) {
        Camera camera;
        camera.orbit(yaw, pitch);
        camera.fit(box, kAspect, covered);
        EXPECT_NEAR(camera.yaw, yaw, 1e-12);
        EXPECT_NEAR(camera.pitch, pitch, 1e-12);
        double lowest = 1.0, highest = -1.0, widest = 0.0;
        for (int i = 0; i < 8; ++i) {
          const glm::dvec3 p = project(camera, corner(box, i), kAspect);
          lowest = std::min(lowest, p.y);
          highest = std::max(highest, p.y);
          widest = std::max(widest, std::abs(p.x));
        }
        EXPECT_GT(lowest, 2.0 * covered - 1.0) << covered << " " << yaw << " " << pitch;
        EXPECT_LT(std::max(highest, widest), 1.0) << covered << " " << yaw << " " << pitch;
        EXPECT_GT(std::max(highest - lowest, 2.0 * widest), 1.3 * (1.0 - covered));
      }
    }
  }
}

TEST(Camera, bounds_without_extent_give_a_finite_view) {
  for (const Box& box : {Box{}, Box{{1, 2, 3}, {1, 2, 3}}}) {
    Camera camera;
    camera.frame_bounds(box, kAspect);
    EXPECT_GT(camera.distance, 0.5);
    EXPECT_LT(camera.distance, 10.0);
    EXPECT_GT(camera.near_plane(), 0.0);
  }
}

TEST(Camera, an_offset_of_a_million_does_not_move_a_point_in_the_picture) {
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

TEST(Camera, depth_is_one_at_the_near_plane_and_precise_a_hundred_thousand_times_farther) {
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

TEST(Camera, zoom_is_bounded_by_the_scene_and_pitch_stops_short_of_the_poles) {
  Camera camera;
  for (int i = 0; i < 1000; ++i) camera.zoom(0.5);
  EXPECT_GT(camera.distance, 0.0);
  for (int i = 0; i < 1000; ++i) camera.zoom(2.0);
  EXPECT_LE(camera.distance, 1e3 * camera.scene_radius);
  camera.orbit(0.0, 100.0);
  EXPECT_LT(camera.pitch, 1.5707);
}

TEST(Camera, panning_moves_the_picture_by_the_given_share_of_its_height) {
  Camera camera;
  camera.orbit(0.4, 0.3);
  const glm::dvec3 point = camera.target;
  camera.pan(0.25, -0.125);
  const glm::dvec3 p = project(camera, point, 1.0);
  EXPECT_NEAR(p.x, -0.5, 1e-12);
  EXPECT_NEAR(p.y, 0.25, 1e-12);
}

/// Cameras that look askew, near the world's origin and far from it.
std::vector<Camera> askew_cameras() {
  std::vector<Camera> cameras;
  for (const char up : {'y', 'z'}) {
    for (const glm::dvec3& middle : {glm::dvec3(0.0), glm::dvec3(4e6, -7e6, 2e5)}) {
      Camera& camera = cameras.emplace_back();
      camera.up = up;
      camera.frame_bounds({middle - 1.0, middle + 1.0}, kAspect);
      camera.orbit(0.8, 0.35);
    }
  }
  return cameras;
}

/// The point at `depth` in front of the eye that is seen at `cursor`.
glm::dvec3 point_under(const Camera& camera, const glm::dvec2& cursor, double depth) {
  const glm::dmat3 axes = camera.axes();
  const double t = depth * std::tan(0.5 * camera.fov_y);
  return camera.eye() + t * (kAspect * cursor.x * axes[0] + cursor.y * axes[1]) - depth * axes[2];
}

TEST(Camera, zooming_at_the_cursor_keeps_the_point_under_it_in_place) {
  for (const Camera& before : askew_cameras()) {
    for (const glm::dvec2& cursor : {glm::dvec2(0.0), glm::dvec2(-0.7, 0.9), glm::dvec2(0.3, -1)}) {
      for (const double factor : {0.5, 0.9, 1.7}) {
        Camera camera = before;
        camera.zoom_at(factor, cursor, kAspect);
        EXPECT_NEAR(camera.distance, factor * before.distance, 1e-12);
        EXPECT_EQ(camera.yaw, before.yaw);
        EXPECT_EQ(camera.pitch, before.pitch);
        for (const double depth : {before.distance, 1.4 * before.distance}) {
          const glm::dvec3 p = project(camera, point_under(before, cursor, depth), kAspect);
          EXPECT_NEAR(p.x, cursor.x, 1e-8);
          EXPECT_NEAR(p.y, cursor.y, 1e-8);
        }
      }
    }
  }
}

TEST(Camera, zooming_at_the_cursor_is_reversible_and_stops_at_the_limits_of_distance) {
  for (const Camera& before : askew_cameras()) {
    Camera camera = before;
    camera.zoom_at(0.25, {0.6, -0.4}, kAspect);
    camera.zoom_at(4.0, {0.6, -0.4}, kAspect);
    EXPECT_LT(glm::distance(camera.target, before.target), 1e-8);
    EXPECT_NEAR(camera.distance, before.distance, 1e-12);
    for (int i = 0; i < 200; ++i) camera.zoom_at(0.5, {0.6, -0.4}, kAspect);
    const Camera nearest = camera;
    camera.zoom_at(0.5, {-0.9, 0.8}, kAspect);
    EXPECT_EQ(camera, nearest);
    EXPECT_GT(camera.distance, 0.0);
  }
}

TEST(Camera, centring_on_a_point_moves_it_to_the_middle_at_the_same_size) {
  for (const Camera& before : askew_cameras()) {
    const double depth = 0.7 * before.distance;
    const glm::dvec3 point = point_under(before, {0.5, -0.8}, depth);
    Camera camera = before;
    camera.center_on(point);
    EXPECT_EQ(camera.target, point);
    EXPECT_NEAR(camera.distance, depth, 1e-8);
    EXPECT_EQ(camera.yaw, before.yaw);
    EXPECT_EQ(camera.pitch, before.pitch);
    // From then on the eye turns about this point.
    camera.orbit(1.1, -0.6);
    const glm::dvec3 p = project(camera, point, kAspect);
    EXPECT_NEAR(p.x, 0.0, 1e-8);
    EXPECT_NEAR(p.y, 0.0, 1e-8);
  }
}

TEST(Camera, centring_on_a_point_at_or_behind_the_eye_keeps_the_distance_in_bounds) {
  for (const Camera& before : askew_cameras()) {
    Camera camera = before;
    camera.center_on(point_under(before, {0.0, 0.0}, -2.0));
    EXPECT_EQ(camera.distance, before.distance);
    camera = before;
    camera.center_on(point_under(before, {0.0, 0.0}, 1e-7));
    EXPECT_GE(camera.distance, 0.99e-3 * before.scene_radius);
  }
}

TEST(Camera, flying_turns_on_the_spot_to_the_left_and_down) {
  for (const Camera& before : askew_cameras()) {
    Camera camera = before;
    camera.fly(glm::dvec3(0.0), 0.3, 0.2);
    EXPECT_LT(glm::distance(camera.eye(), before.eye()), 1e-8);
    EXPECT_EQ(camera.distance, before.distance);
    // The previous centre of the picture is now to the right and above.
    const glm::dvec3 p = project(camera, before.target, kAspect);
    EXPECT_GT(p.x, 0.1);
    EXPECT_GT(p.y, 0.1);
    camera.fly(glm::dvec3(0.0), -0.3, -0.2);
    EXPECT_LT(glm::distance(camera.target, before.target), 1e-8);
    camera.fly(glm::dvec3(0.0), 0.0, 100.0);
    EXPECT_LT(camera.pitch, 1.5707);
    EXPECT_LT(glm::distance(camera.eye(), before.eye()), 1e-8);
  }
}

TEST(Camera, flying_moves_the_eye_right_up_and_forward) {
  for (const Camera& before : askew_cameras()) {
    const glm::dmat3 axes = before.axes();
    const glm::dvec3 above = before.up == 'z' ? glm::dvec3(0, 0, 1) : glm::dvec3(0, 1, 0);
    Camera camera = before;
    camera.fly({0.5, 0.25, 2.0}, 0.0, 0.0);
    const glm::dvec3 expected = 0.5 * axes[0] + 0.25 * above - 2.0 * axes[2];
    EXPECT_LT(glm::distance(camera.eye() - before.eye(), expected), 1e-8);
    EXPECT_LT(glm::distance(camera.target - before.target, expected), 1e-8);
  }
}

}  // namespace
}  // namespace pointreel::camera_test
