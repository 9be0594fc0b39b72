#include "codec/files/camera_intrinsics.h"

#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace pointreel::camera_intrinsics_test {
namespace {

using testing::HasSubstr;

CameraIntrinsics parsed(const std::string& json) {
  const auto camera = parse_camera_intrinsics(json);
  EXPECT_TRUE(camera) << camera.error().message;
  return camera.value_or(CameraIntrinsics{});
}

std::string error_of(const std::string& json) {
  const auto camera = parse_camera_intrinsics(json);
  return camera ? "it was read" : camera.error().message;
}

void expect_camera(const CameraIntrinsics& camera) {
  EXPECT_EQ(camera.fx, 525.5);
  EXPECT_EQ(camera.fy, 524.0);
  EXPECT_EQ(camera.cx, 319.5);
  EXPECT_EQ(camera.cy, 239.25);
}

TEST(CameraIntrinsics, are_read_as_different_programs_write_them) {
  const CameraIntrinsics open3d = parsed(
      R"({"width": 640, "height": 480,
          "intrinsic_matrix": [525.5, 0, 0, 0, 524, 0, 319.5, 239.25, 1]})");
  expect_camera(open3d);
  EXPECT_EQ(open3d.width, 640u);
  EXPECT_EQ(open3d.height, 480u);
  EXPECT_EQ(open3d.steps_per_meter, 1000.0);
  EXPECT_FALSE(open3d.distorts);
  expect_camera(parsed(R"({"intrinsic_matrix": [525.5, 0, 319.5, 0, 524, 239.25, 0, 0, 1]})"));
  expect_camera(
      parsed(R"({"intrinsic_matrix": [[525.5, 0, 319.5], [0, 524, 239.25], [0, 0, 1]]})"));
  expect_camera(parsed(R"({"fx": 525.5, "fy": 524, "cx": 319.5, "cy": 239.25})"));
  expect_camera(parsed(R"({"fx": 525.5, "fy": 524, "ppx": 319.5, "ppy": 239.25})"));
  for (const char* const name : {"K", "k", "camera_matrix"})
    expect_camera(parsed("{\"" + std::string(name) +
                         R"(": [525.5, 0, 319.5, 0, 524, 239.25, 0, 0, 1], "D": [0, 0]})"));
  expect_camera(parsed(
      R"({"camera_matrix": {"rows": 3, "data": [525.5, 0, 319.5, 0, 524, 239.25, 0, 0, 1]}})"));
  const CameraIntrinsics nerfstudio =
      parsed(R"({"w": 640, "h": 480, "fl_x": 525.5, "fl_y": 524, "cx": 319.5, "cy": 239.25})");
  expect_camera(nerfstudio);
  EXPECT_EQ(nerfstudio.width, 640u);
  EXPECT_EQ(nerfstudio.height, 480u);
}

TEST(CameraIntrinsics, the_scale_of_depth_may_be_steps_per_meter_or_meters_per_step) {
  const std::string camera = R"({"fx": 500, "fy": 500, "cx": 1, "cy": 1, "depth_scale": )";
  EXPECT_EQ(parsed(camera + "5000}").steps_per_meter, 5000.0);
  EXPECT_EQ(parsed(camera + "0.00025}").steps_per_meter, 4000.0);
  EXPECT_EQ(parsed(camera + "1}").steps_per_meter, 1.0);
  EXPECT_EQ(parsed(R"({"fx": 9, "fy": 9, "cx": 1, "cy": 1, "depth_factor": 5000})").steps_per_meter,
            5000.0);
  EXPECT_EQ(parsed(R"({"fx": 9, "fy": 9, "cx": 1, "cy": 1, "depth_units": 0.5})").steps_per_meter,
            2.0);
}

TEST(CameraIntrinsics, distortion_is_noticed) {
  const std::string camera = R"({"fx": 500, "fy": 500, "cx": 1, "cy": 1, )";
  EXPECT_TRUE(parsed(camera + R"("coeffs": [0, 0.1, 0, 0, 0]})").distorts);
  EXPECT_TRUE(parsed(camera + R"("k1": -0.2})").distorts);
  EXPECT_FALSE(parsed(camera + R"("coeffs": [0, 0, 0, 0, 0], "k1": 0})").distorts);
}

TEST(CameraIntrinsics, each_fault_is_named) {
  EXPECT_THAT(error_of(""), HasSubstr("JSON"));
  EXPECT_THAT(error_of("[1, 2]"), HasSubstr("not an object"));
  EXPECT_THAT(error_of("{}"), HasSubstr("neither intrinsic_matrix nor fx"));
  EXPECT_THAT(error_of(R"({"CalibrationInformation": {"Cameras": []}})"),
              HasSubstr("neither intrinsic_matrix nor fx"));
  for (const char* matrix : {"5", "[]", "[1, 2, 3]", "[1, 0, 0, 0, 1, 0, 0, 0, 1, 0]",
                             "[\"1\", 0, 0, 0, 1, 0, 0, 0, 1]"})
    EXPECT_THAT(error_of(std::string(R"({"intrinsic_matrix": )") + matrix + "}"),
                HasSubstr("intrinsic_matrix: is not a matrix of nine numbers"))
        << matrix;
  EXPECT_THAT(error_of(R"({"intrinsic_matrix": [500, 1, 0, 0, 500, 0, 320, 240, 1]})"),
              HasSubstr("is not [fx, 0"));
  EXPECT_THAT(error_of(R"({"fx": 500, "fy": 500, "cx": 320})"), HasSubstr("cy: is missing"));
  EXPECT_THAT(error_of(R"({"fx": 0, "fy": 500, "cx": 320, "cy": 240})"), HasSubstr("fx: is no"));
  EXPECT_THAT(error_of(R"({"fx": 500, "fy": -500, "cx": 320, "cy": 240})"), HasSubstr("fy: is no"));
  EXPECT_THAT(error_of(R"({"fx": 500, "fy": 500, "cx": 1e300, "cy": 240})"),
              HasSubstr("cx: is no"));
  EXPECT_THAT(error_of(R"({"fx": 500, "fy": 500, "cx": 1, "cy": 1, "depth_scale": 0})"),
              HasSubstr("depth_scale: is not from"));
  EXPECT_THAT(error_of(R"({"fx": 500, "fy": 500, "cx": 1, "cy": 1, "depth_scale": -1000})"),
              HasSubstr("depth_scale: is not from"));
  EXPECT_THAT(error_of(R"({"fx": 500, "fy": 500, "cx": 1, "cy": 1, "width": 640})"),
              HasSubstr("height: is missing"));
  EXPECT_THAT(error_of(R"({"fx": 500, "fy": 500, "cx": 1, "cy": 1, "width": 0, "height": 1})"),
              HasSubstr("width: or height is 0"));
}

}  // namespace
}  // namespace pointreel::camera_intrinsics_test
