#include "codec/files/depth_points.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdlib>
#include <optional>
#include <string>
#include <vector>

#include <glm/glm.hpp>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "codec/files/cloud_file.h"
#include "codec/files/depth_frame.h"
#include "tests/depth_scene.h"
#include "tests/view.h"

namespace pointreel::depth_points_test {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

/// In the camera's coordinates, with y down and z ahead.
glm::dvec3 as_camera(const glm::vec3& p) { return {p.x, -p.y, -p.z}; }

glm::dvec2 pixel_of(const CameraIntrinsics& camera, const glm::dvec3& p) {
  return {camera.fx * p.x / p.z + camera.cx, camera.fy * p.y / p.z + camera.cy};
}

DepthPicture picture_of(std::uint32_t width, std::vector<std::uint16_t> values) {
  const auto height = static_cast<std::uint32_t>(values.size() / width);
  return {width, height, std::move(values)};
}

TEST(DepthPoints, a_ball_before_a_wall_is_where_it_is_within_half_a_step) {
  for (const double steps : {1000.0, 5000.0}) {
    const CameraIntrinsics camera = depth_scene::camera(320, steps);
    const ColorPicture color = depth_scene::color(camera, 2);
    const PointCloud cloud = depth_points(depth_scene::depth(camera, 2), camera, &color);
    EXPECT_GT(cloud.size(), 0.98 * 320 * 240);
    ASSERT_EQ(cloud.colors.size(), cloud.size());
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      const glm::dvec3 p = as_camera(cloud.positions[i]);
      const glm::dvec2 pixel = pixel_of(camera, p);
      ASSERT_NEAR(pixel.x, std::round(pixel.x), 1e-3);
      ASSERT_NEAR(pixel.y, std::round(pixel.y), 1e-3);
      const auto seen = depth_scene::look(camera, std::round(pixel.x), std::round(pixel.y), 2);
      ASSERT_NEAR(p.z, seen.depth, 0.5 / steps + 1e-6);
      const std::size_t at =
          3 * static_cast<std::size_t>(std::round(pixel.y) * 320.0 + std::round(pixel.x));
      ASSERT_EQ(cloud.colors[i], glm::u16vec3(257 * color.rgb[at], 257 * color.rgb[at + 1],
                                              257 * color.rgb[at + 2]));
    }
  }
}

TEST(DepthPoints, normals_are_those_of_the_surface_and_face_the_camera) {
  const CameraIntrinsics camera = depth_scene::camera(640, 5000.0);
  const PointCloud cloud = depth_points(depth_scene::depth(camera, 2), camera, nullptr);
  ASSERT_EQ(cloud.normals.size(), cloud.size());
  EXPECT_THAT(cloud.colors, IsEmpty());
  double wall = 0.0, ball = 0.0;
  std::size_t walls = 0, balls = 0;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const glm::dvec3 p = as_camera(cloud.positions[i]), n = as_camera(cloud.normals[i]);
    ASSERT_NEAR(glm::length(n), 1.0, 1e-5);
    ASSERT_LT(glm::dot(n, p), 0.0);
    const glm::dvec2 pixel = pixel_of(camera, p);
    const auto seen = depth_scene::look(camera, pixel.x, pixel.y, 2);
    const double degrees =
        glm::degrees(std::acos(std::min(1.0, glm::dot(n, glm::normalize(seen.normal)))));
    // Where the ball curves away, pixels are far apart.
    if (seen.ball && glm::dot(seen.normal, glm::normalize(-p)) < 0.5) continue;
    (seen.ball ? ball : wall) += degrees;
    ++(seen.ball ? balls : walls);
  }
  EXPECT_GT(balls, 10'000u);
  // Steps of a fifth of a millimetre at pixels of about four.
  EXPECT_LT(wall / static_cast<double>(walls), 0.5);
  EXPECT_LT(ball / static_cast<double>(balls), 1.0);
}

TEST(DepthPoints, what_was_not_measured_is_no_point) {
  const PointCloud cloud =
      depth_points(picture_of(2, {0, 1000, 65535, 1000}), depth_scene::camera(2), nullptr);
  EXPECT_EQ(cloud.size(), 2u);
  EXPECT_TRUE(depth_points(picture_of(2, {0, 0, 0, 0}), depth_scene::camera(2), nullptr).empty());
}

TEST(DepthPoints, pixels_that_fly_between_two_surfaces_are_left_out_and_no_others) {
  // A pole one metre away before a wall at two metres. On its left, pixels mix both; its right is
  // clean, and so is the wall in its shadow.
  std::vector<std::uint16_t> values;
  for (int y = 0; y < 8; ++y)
    for (const int z : {2000, 2000, 1700, 1300, 1000, 1010, 1000, 0, 2000, 2000})
      values.push_back(static_cast<std::uint16_t>(z));
  const PointCloud cloud = depth_points(picture_of(10, values), depth_scene::camera(10), nullptr);
  EXPECT_EQ(cloud.size(), 8u * 7u);
  for (const glm::vec3& p : cloud.positions) EXPECT_TRUE(p.z == -2.0f || p.z > -1.02f) << p.z;
}

TEST(DepthPoints, a_surface_that_the_camera_sees_at_80_degrees_is_whole) {
  CameraIntrinsics camera;
  camera.fx = camera.fy = 500.0;
  camera.cx = 30.0;
  camera.cy = 20.0;
  camera.steps_per_meter = 10'000.0;
  DepthPicture depth{60, 40, {}};
  const double tangent = std::tan(glm::radians(80.0));
  for (int y = 0; y < 40; ++y)
    for (int x = 0; x < 60; ++x)
      depth.values.push_back(static_cast<std::uint16_t>(
          std::lround(10'000.0 * 2.0 / (1.0 + tangent * (x - camera.cx) / camera.fx))));
  EXPECT_EQ(depth_points(depth, camera, nullptr).size(), depth.values.size());
}

TEST(DepthPoints, a_pixel_alone_faces_the_camera) {
  std::vector<std::uint16_t> values(25, 0);
  values[12] = 1500;
  const PointCloud cloud = depth_points(picture_of(5, values), depth_scene::camera(5), nullptr);
  ASSERT_EQ(cloud.size(), 1u);
  EXPECT_LT(glm::distance(cloud.normals[0], -glm::normalize(cloud.positions[0])), 1e-5f);
}

Result<LoadedCloud> read_frame(const CameraIntrinsics& camera, const DepthPicture& depth,
                               const std::optional<ColorPicture>& color) {
  const std::string colors = color ? depth_scene::png(*color) : std::string();
  return read_cloud(
      depth_frame(depth_scene::intrinsics(camera), view(depth_scene::png(depth)), view(colors)),
      CloudFormat::depth_frame);
}

TEST(DepthFrame, intrinsics_and_colors_of_another_resolution_fit) {
  const CameraIntrinsics camera = depth_scene::camera(160), large = depth_scene::camera(640);
  const DepthPicture depth = depth_scene::depth(camera, 1);
  const auto same = read_frame(camera, depth, depth_scene::color(camera, 1));
  ASSERT_TRUE(same) << same.error().message;
  EXPECT_THAT(same->unread, IsEmpty());
  EXPECT_THAT(same->warnings, IsEmpty());
  CameraIntrinsics scaled = large;
  // The same rays: pixels count from their centres.
  scaled.cx = 4.0 * (camera.cx + 0.5) - 0.5;
  scaled.cy = 4.0 * (camera.cy + 0.5) - 0.5;
  const auto other = read_frame(scaled, depth, depth_scene::color(scaled, 1));
  ASSERT_TRUE(other) << other.error().message;
  ASSERT_EQ(other->cloud.size(), same->cloud.size());
  std::size_t differ = 0;
  for (std::size_t i = 0; i < same->cloud.size(); ++i) {
    ASSERT_LT(glm::distance(same->cloud.positions[i], other->cloud.positions[i]), 1e-5f);
    const glm::ivec3 a(same->cloud.colors[i]), b(other->cloud.colors[i]);
    differ += std::abs(a.x - b.x) > 5 * 257;
  }
  EXPECT_LT(differ, same->cloud.size() / 50) << "at the edge of the ball only";
}

TEST(DepthFrame, what_is_of_another_camera_is_refused_or_left_out_and_said) {
  const CameraIntrinsics camera = depth_scene::camera(160);
  const DepthPicture depth = depth_scene::depth(camera, 1);
  CameraIntrinsics wide = camera;
  wide.width = 1280;
  wide.height = 720;
  const auto refused = read_frame(wide, depth, std::nullopt);
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().message,
              HasSubstr("intrinsics: are for 1280 x 720 pixels, but the depth has 160 x 120"));
  const auto larger = read_cloud(depth_frame(R"({"fx": 525, "fy": 525, "cx": 319.5, "cy": 239.5})",
                                             view(depth_scene::png(depth)), {}),
                                 CloudFormat::depth_frame);
  ASSERT_FALSE(larger);
  EXPECT_THAT(larger.error().message,
              HasSubstr("centre at 319.5 239.5, outside of the depth's 160 x 120 pixels"));
  const auto left = read_frame(camera, depth, depth_scene::color(wide, 1));
  ASSERT_TRUE(left) << left.error().message;
  EXPECT_FALSE(left->cloud.has_colors());
  EXPECT_THAT(left->unread, ElementsAre(HasSubstr("colours of 1280 x 720 pixels that do not lie")));
}

TEST(DepthFrame, errors_name_the_part) {
  const CameraIntrinsics camera = depth_scene::camera(160);
  const std::string good = depth_scene::intrinsics(camera),
                    depth = depth_scene::png(depth_scene::depth(camera, 0));
  const auto error_of = [](const Bytes& bytes, const DecodeLimits& limits = {}) {
    const auto loaded = read_cloud(bytes, CloudFormat::depth_frame, limits);
    return loaded ? "it was read" : loaded.error().message;
  };
  EXPECT_EQ(error_of(depth_frame(good, view(depth), {})), "it was read");
  EXPECT_THAT(error_of(depth_frame("{}", view(depth), {})), HasSubstr("intrinsics: has neither"));
  EXPECT_THAT(error_of(depth_frame(good, view("abc"), {})), HasSubstr("depth: is not a PNG"));
  EXPECT_THAT(error_of(depth_frame(good, view(depth), view("abc"))),
              HasSubstr("color: is neither a PNG nor a JPEG"));
  EXPECT_THAT(error_of(depth_frame(good, view(depth), {}), {.max_points = 1000}),
              HasSubstr("depth: has 160 x 120 pixels; at most 1000"));
  EXPECT_THAT(error_of(depth_frame(good, view(depth), {}), {.max_memory = 1u << 20}),
              HasSubstr("at most 16384 are accepted; raise --frame-memory"));
  // Depth takes 160 * 120 * 64 bytes, and leaves too few for as many colours.
  const std::string color = depth_scene::png(depth_scene::color(camera, 0));
  const DecodeLimits little{.max_memory = 160 * 120 * (64 + 4)};
  EXPECT_EQ(error_of(depth_frame(good, view(depth), {}), little), "it was read");
  EXPECT_THAT(error_of(depth_frame(good, view(depth), view(color)), little),
              HasSubstr("color: has 160 x 120 pixels; at most 9600"));
  Bytes cut = depth_frame(good, view(depth), {});
  for (const std::size_t size :
       {std::size_t{1}, std::size_t{7}, std::size_t{100}, cut.size() - 1}) {
    cut.resize(size);
    EXPECT_THAT(error_of(cut), HasSubstr("ends within its parts"));
    cut = depth_frame(good, view(depth), {});
  }
}

}  // namespace
}  // namespace pointreel::depth_points_test
