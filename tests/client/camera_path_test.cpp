#include "client/scene/camera_path.h"

#include <cmath>
#include <fstream>
#include <numbers>
#include <string>

#include <gtest/gtest.h>

#include "tests/temporary_folder.h"

namespace pointreel::camera_path_test {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

CameraKey key(double seconds, double yaw_degrees, double pitch_degrees = 0.0) {
  CameraKey key;
  key.time_us = static_cast<std::uint64_t>(std::llround(seconds * 1e6));
  key.yaw = yaw_degrees * kDegree;
  key.pitch = pitch_degrees * kDegree;
  return key;
}

double yaw_at(const CameraPath& path, double seconds) {
  return path.at(static_cast<std::uint64_t>(std::llround(seconds * 1e6)), Camera()).yaw / kDegree;
}

CameraPath recorded() {
  CameraPath path;
  path.up = Up('z', true);
  Camera camera;
  camera.target = {500'000.25, -20.0, 0.125};
  camera.fov_y = 0.5;
  path.set(key_of(camera, 33'333));
  camera.orbit(0.7, -0.3);
  camera.zoom(0.25);
  path.set(key_of(camera, 1'000'000));
  camera.target += glm::dvec3(1.0, 2.0, -3.0);
  camera.fov_y = 1.0;
  path.set(key_of(camera, 1'700'001));
  return path;
}

TEST(CameraPath, passes_through_every_key_at_its_time) {
  const CameraPath path = recorded();
  for (const CameraKey& key : path.keys) {
    const Camera camera = path.at(key.time_us, Camera());
    EXPECT_EQ(camera.up, Up('z', true));
    EXPECT_NEAR(glm::distance(camera.target, *key.target), 0.0, 1e-9);
    EXPECT_NEAR(camera.distance, *key.distance, 1e-12);
    EXPECT_NEAR(camera.yaw, key.yaw, 1e-12);
    EXPECT_NEAR(camera.pitch, key.pitch, 1e-12);
    EXPECT_NEAR(camera.fov_y, *key.fov_y, 1e-12);
  }
}

TEST(CameraPath, stands_still_before_its_first_key_and_after_its_last) {
  const CameraPath path = recorded();
  EXPECT_EQ(path.at(0, Camera()), path.at(33'333, Camera()));
  EXPECT_EQ(path.at(9'000'000, Camera()), path.at(1'700'001, Camera()));
}

TEST(CameraPath, turns_the_shorter_way_round) {
  CameraPath path;
  path.keys = {key(0.0, 170.0), key(1.0, -170.0)};
  EXPECT_NEAR(yaw_at(path, 0.25), 175.0, 1e-9);
  EXPECT_NEAR(std::abs(yaw_at(path, 0.5)), 180.0, 1e-9);
  EXPECT_NEAR(yaw_at(path, 0.75), -175.0, 1e-9);
  path.keys = {key(0.0, 10.0), key(1.0, 350.0)};
  EXPECT_NEAR(yaw_at(path, 0.5), 0.0, 1e-9);
}

TEST(CameraPath, a_turntable_of_even_keys_turns_at_a_constant_rate) {
  CameraPath path;
  path.keys = {key(0.0, 0.0), key(1.0, 120.0), key(2.0, 240.0), key(3.0, 360.0)};
  for (int i = 0; i <= 30; ++i) {
    const double expected = 12.0 * i;
    EXPECT_NEAR(std::remainder(yaw_at(path, 0.1 * i) - expected, 360.0), 0.0, 1e-9) << i;
  }
}

TEST(CameraPath, changes_its_speed_smoothly_at_keys) {
  CameraPath path;
  path.keys = {key(0.0, 0.0, 5.0), key(0.4, 30.0, 6.0), key(1.5, 50.0, 40.0), key(1.7, 90.0, 41.0)};
  for (const double at : {0.4, 1.5}) {
    const double before = (yaw_at(path, at) - yaw_at(path, at - 1e-5)) / 1e-5;
    const double after = (yaw_at(path, at + 1e-5) - yaw_at(path, at)) / 1e-5;
    EXPECT_NEAR(before, after, 0.01 * std::abs(before)) << at;
  }
}

TEST(CameraPath, never_overshoots_a_key_and_stands_still_between_equal_keys) {
  CameraPath path;
  path.keys = {key(0.0, 0.0), key(1.0, 40.0), key(2.0, 40.0), key(2.1, 0.0), key(3.0, 5.0)};
  double last = 0.0;
  for (int i = 0; i <= 300; ++i) {
    const double yaw = yaw_at(path, 0.01 * i);
    EXPECT_LE(yaw, 40.0 + 1e-9);
    EXPECT_GE(yaw, -1e-9);
    if (i <= 100) {
      EXPECT_GE(yaw, last - 1e-9) << i;
    } else if (i <= 200) {
      EXPECT_NEAR(yaw, 40.0, 1e-9) << i;
    }
    last = yaw;
  }
}

TEST(CameraPath, zooms_by_equal_factors_in_equal_times) {
  CameraPath path;
  path.keys = {key(0.0, 0.0), key(2.0, 0.0)};
  path.keys[0].distance = 8.0;
  path.keys[1].distance = 0.5;
  EXPECT_NEAR(path.at(1'000'000, Camera()).distance, 2.0, 1e-12);
  EXPECT_NEAR(path.at(500'000, Camera()).distance, 4.0, 1e-12);
}

TEST(CameraPath, keeps_the_framed_view_for_values_that_its_keys_omit) {
  const auto path = parse_camera_path(
      R"({"pointreel_camera_path": 1, "keys": [{"seconds": 0, "yaw": 90}, {"seconds": 2}]})");
  ASSERT_TRUE(path) << path.error().message;
  Camera framed;
  framed.target = {1.0, 2.0, 3.0};
  framed.distance = 7.0;
  framed.up = 'z';
  framed.pitch = 0.15;
  framed.scene_radius = 2.5;
  const Camera camera = path->at(1'000'000, framed);
  EXPECT_EQ(camera.target, framed.target);
  EXPECT_NEAR(camera.distance, 7.0, 1e-12);
  EXPECT_EQ(camera.up, 'z');
  EXPECT_EQ(camera.scene_radius, 2.5);
  EXPECT_NEAR(camera.yaw / kDegree, 45.0, 1e-9);
  EXPECT_EQ(camera.pitch, 0.0);
  EXPECT_NEAR(camera.fov_y, framed.fov_y, 1e-15);
}

TEST(CameraPath, keeps_its_keys_in_order_and_replaces_a_key_at_the_same_time) {
  CameraPath path;
  path.set(key(2.0, 20.0));
  path.set(key(1.0, 10.0));
  path.set(key(3.0, 30.0));
  path.set(key(2.0, 25.0));
  ASSERT_EQ(path.keys.size(), 3u);
  EXPECT_EQ(path.keys[0], key(1.0, 10.0));
  EXPECT_EQ(path.keys[1], key(2.0, 25.0));
  EXPECT_EQ(path.keys[2], key(3.0, 30.0));
}

TEST(CameraPathFile, is_read_back_as_it_was_saved) {
  const TemporaryFolder folder;
  const std::string file = (folder / "path.json").string();
  const CameraPath path = recorded();
  ASSERT_TRUE(save_camera_path(file, path));
  const auto loaded = load_camera_path(file);
  ASSERT_TRUE(loaded) << loaded.error().message;
  EXPECT_EQ(loaded->up, Up('z', true));
  ASSERT_EQ(loaded->keys.size(), path.keys.size());
  for (std::size_t i = 0; i < path.keys.size(); ++i) {
    EXPECT_EQ(loaded->keys[i].time_us, path.keys[i].time_us);
    EXPECT_EQ(loaded->keys[i].target, path.keys[i].target);
    EXPECT_EQ(loaded->keys[i].distance, path.keys[i].distance);
    EXPECT_NEAR(loaded->keys[i].yaw, path.keys[i].yaw, 1e-10);
    EXPECT_NEAR(loaded->keys[i].pitch, path.keys[i].pitch, 1e-10);
    EXPECT_NEAR(*loaded->keys[i].fov_y, *path.keys[i].fov_y, 1e-10);
  }
  EXPECT_FALSE(std::filesystem::exists(file + ".part"));
}

TEST(CameraPathFile, names_the_problem_and_its_place_in_an_invalid_file) {
  const auto error = [](const std::string& text) {
    const auto path = parse_camera_path(text);
    return path ? "accepted" : path.error().message;
  };
  const auto keys = [&](const std::string& list) {
    return error(R"({"pointreel_camera_path": 1, "keys": [)" + list + "]}");
  };
  EXPECT_EQ(error("ply\nformat"), "is not valid JSON");
  EXPECT_EQ(error("[]"), "is not a camera path: is not a JSON object");
  EXPECT_EQ(error("{}"), "is not a camera path: pointreel_camera_path: is missing");
  EXPECT_EQ(error(R"({"pointreel_camera_path": 2})"),
            "is a camera path of format 2, but this player reads format 1");
  EXPECT_EQ(error(R"({"pointreel_camera_path": 1, "up": "w", "keys": [{"seconds": 0}]})"),
            "up: is not one of x, -x, y, -y, z, -z");
  EXPECT_EQ(keys(""), "keys: must be a list of 1 to 10000");
  EXPECT_EQ(keys("{}"), "keys[0]: seconds: is missing");
  EXPECT_EQ(keys(R"({"seconds": -1})"), "keys[0]: seconds: is not from 0 to 1000000000");
  EXPECT_EQ(keys(R"({"seconds": 1}, {"seconds": 1})"),
            "keys[1]: seconds: must be greater than those of the key before");
  EXPECT_EQ(keys(R"({"seconds": 0, "pitch": 90.5})"), "keys[0]: pitch: is not from -90 to 90");
  EXPECT_EQ(keys(R"({"seconds": 0, "distance": 0})"),
            "keys[0]: distance: is not from 1e-09 to 1000000000000");
  EXPECT_EQ(keys(R"({"seconds": 0, "target": [0, 1]})"),
            "keys[0]: target: is not three finite numbers");
  EXPECT_EQ(keys(R"({"seconds": 0, "target": [0, 1, 1e13]})"),
            "keys[0]: target: is not from -1000000000000 to 1000000000000");
  EXPECT_EQ(keys(R"({"seconds": 0, "fov": "wide"})"), "keys[0]: fov: is not a number");
  EXPECT_EQ(keys(R"({"seconds": 0}, {"seconds": 1, "pich": 3})"),
            "keys[1]: pich: is not known here; there may be seconds, target, distance, yaw, pitch, "
            "fov");
  EXPECT_EQ(error(R"({"pointreel_camera_path": 1, "Up": "z", "keys": [{"seconds": 0}]})"),
            "Up: is not known here; there may be pointreel_camera_path, up, keys");
}

TEST(CameraPathFile, names_the_file_in_every_error) {
  const TemporaryFolder folder;
  const std::string missing = (folder / "none.json").string();
  EXPECT_EQ(load_camera_path(missing).error().message,
            missing + ": cannot be opened: No such file or directory");
  const std::string bad = folder.write("bad.json", "{}").string();
  EXPECT_TRUE(load_camera_path(bad).error().message.starts_with(bad + ": is not a camera path"));
  EXPECT_TRUE(load_camera_path(folder.path().string())
                  .error()
                  .message.starts_with(folder.path().string() + ": "));
  const std::string nowhere = (folder / "no/such.json").string();
  EXPECT_EQ(save_camera_path(nowhere, recorded()).error().message,
            nowhere + ": cannot be written: No such file or directory");
}

}  // namespace
}  // namespace pointreel::camera_path_test
