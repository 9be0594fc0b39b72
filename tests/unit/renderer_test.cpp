#include "client/render/renderer.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <limits>
#include <memory>
#include <numbers>
#include <random>
#include <string_view>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <png.h>

#include "tests/unit/drawing_test.h"

namespace pointreel {
namespace {

constexpr glm::ivec2 kSize(240, 180);
constexpr glm::u16vec3 kRed(0xffff, 0, 0), kGreen(0, 0xffff, 0), kBlue(0, 0, 0xffff),
    kOrange(0xffff, 0x8080, 0x2020);
constexpr glm::vec3 kFront(0.0f, 0.0f, 1.0f);

int difference(const glm::u8vec3& a, const glm::u8vec3& b) {
  return std::max({std::abs(a.x - b.x), std::abs(a.y - b.y), std::abs(a.z - b.z)});
}

glm::u8vec3 eight_bits(const glm::u16vec3& c) { return glm::u8vec3(c / std::uint16_t{257}); }

int largest_difference(const Image& a, const Image& b) {
  if (a.pixels.size() != b.pixels.size()) return 256;
  int largest = 0;
  for (std::size_t i = 0; i < a.pixels.size(); ++i) {
    largest = std::max(largest, difference(a.pixels[i], b.pixels[i]));
  }
  return largest;
}

std::size_t count_near(const Image& image, const glm::u8vec3& color, int within = 3) {
  return static_cast<std::size_t>(
      std::count_if(image.pixels.begin(), image.pixels.end(),
                    [&](const glm::u8vec3& p) { return difference(p, color) <= within; }));
}

void add(PointCloud& cloud, const glm::vec3& p, const glm::vec3& n, const glm::u16vec3& color,
         float radius) {
  cloud.positions.push_back(p);
  cloud.normals.push_back(n);
  cloud.colors.push_back(color);
  cloud.radii.push_back(radius);
}

std::shared_ptr<SceneFrame> frame_of(PointCloud cloud, int depth = 5) {
  auto frame = std::make_shared<SceneFrame>();
  frame->cloud = std::move(cloud);
  // One cube for all of them, so that a voxel's place does not depend on the other points.
  const SortedPoints sorted = sort_points(frame->cloud, {frame->cloud.origin - 1.5, 3.0});
  frame->svo = build_svo(sorted, depth);
  frame->attributes = mean_attributes(frame->svo, frame->cloud, sorted);
  return frame;
}

/// Four colours, none of them on the boundary of a voxel, no two of them where a mirrored axis or a
/// rotation would put another.
PointCloud asymmetric_cloud() {
  PointCloud cloud;
  add(cloud, {0.8f, 0.14f, 0.04f}, kFront, kRed, 0.1f);
  add(cloud, {0.23f, 0.7f, 0.04f}, kFront, kGreen, 0.1f);
  add(cloud, {-0.52f, -0.42f, 0.24f}, kFront, kBlue, 0.1f);
  add(cloud, {0.04f, 0.04f, 0.04f}, kFront, kOrange, 0.1f);
  return cloud;
}

Camera front_camera() {
  Camera camera;
  camera.distance = 4.0;
  return camera;
}

/// The pixel in which a world point lies, by arithmetic of its own.
glm::ivec2 pixel_of(const Camera& camera, const glm::dvec3& world, glm::ivec2 size = kSize) {
  const glm::dvec3 e = glm::transpose(camera.axes()) * (world - camera.eye());
  const double f = 0.5 * size.y / std::tan(0.5 * camera.fov_y);
  return glm::ivec2(glm::floor(glm::dvec2(0.5 * size.x + f * e.x / -e.z,  //
                                          0.5 * size.y - f * e.y / -e.z)));
}

DrawOptions plain(DrawMode mode) {
  DrawOptions options;
  options.mode = mode;
  options.lighting = false;
  options.point_size = 5.0f;
  options.background = glm::vec3(0.2f, 0.4f, 0.6f);
  return options;
}

const glm::u8vec3 kBackground(51, 102, 153);
constexpr DrawMode kModes[] = {DrawMode::surfel, DrawMode::voxel, DrawMode::point};

class RendererTest : public DrawingTest {
 protected:
  Image picture(const std::shared_ptr<const SceneFrame>& frame, const Camera& camera,
                const DrawOptions& options, glm::ivec2 size = kSize) {
    return draw(frame, camera, size, options);
  }
};

TEST_F(RendererTest, DrawsEachColourAtItsPlaceInEveryMode) {
  const PointCloud cloud = asymmetric_cloud();
  const auto frame = frame_of(cloud);
  for (const char up : {'y', 'z'}) {
    Camera camera = front_camera();
    camera.up = up;
    if (up == 'z') camera.orbit(0.0, 1.5);  // from above, so that the normals face the eye
    for (const DrawMode mode : kModes) {
      const Image image = picture(frame, camera, plain(mode));
      for (std::size_t i = 0; i < cloud.size(); ++i) {
        const glm::ivec2 at = pixel_of(camera, cloud.world(i));
        EXPECT_LE(difference(image.at(at.x, at.y), eight_bits(cloud.colors[i])), 2)
            << "mode " << static_cast<int>(mode) << " up " << up << " point " << i;
        EXPECT_GE(count_near(image, eight_bits(cloud.colors[i])), 20u);
      }
      EXPECT_EQ(difference(image.at(1, 1), kBackground), 0);
      EXPECT_GT(count_near(image, kBackground, 0), image.pixels.size() * 3 / 4);
      EXPECT_EQ(stats_.drawn, 4u);
    }
  }
}

TEST_F(RendererTest, TurnsTheSceneTheOtherWayWhenTheEyeMovesRight) {
  PointCloud cloud;
  add(cloud, {0.04f, 0.04f, 0.8f}, kFront, kRed, 0.1f);  // nearer than the target
  const auto frame = frame_of(cloud);
  Camera camera = front_camera();
  camera.orbit(0.4, 0.0);
  for (const DrawMode mode : kModes) {
    const Image image = picture(frame, camera, plain(mode));
    const glm::ivec2 at = pixel_of(camera, cloud.world(0));
    EXPECT_LT(at.x, kSize.x / 2 - 5);
    EXPECT_LE(difference(image.at(at.x, at.y), glm::u8vec3(255, 0, 0)), 2);
  }
}

TEST_F(RendererTest, DrawsASceneFarFromTheWorldsZeroTheSameWay) {
  PointCloud cloud = asymmetric_cloud();
  Camera camera = front_camera();
  for (const DrawMode mode : kModes) {
    cloud.origin = glm::dvec3(0.0);
    camera.target = glm::dvec3(0.0);
    const Image here = picture(frame_of(cloud), camera, plain(mode));
    cloud.origin = camera.target = glm::dvec3(1048576.0, -3145728.0, 7340032.0);
    const Image there = picture(frame_of(cloud), camera, plain(mode));
    EXPECT_EQ(largest_difference(here, there), 0);
  }
}

TEST_F(RendererTest, AnEmptyFrameOrNoneIsTheBackground) {
  for (const DrawMode mode : kModes) {
    picture(frame_of(asymmetric_cloud()), front_camera(), plain(mode));
    for (const auto& frame : {std::shared_ptr<SceneFrame>(), std::make_shared<SceneFrame>()}) {
      const Image image = picture(frame, front_camera(), plain(mode));
      EXPECT_EQ(count_near(image, kBackground, 0), image.pixels.size());
      EXPECT_EQ(stats_.drawn, 0u);
    }
  }
}

TEST_F(RendererTest, ASurfelThatFacesAwayIsCulledAndOneOfUnknownOrientationIsNot) {
  const auto pixels_of = [&](const glm::vec3& n) {
    PointCloud cloud;
    add(cloud, glm::vec3(0.0f), n, kOrange, 0.2f);
    DrawOptions options = plain(DrawMode::surfel);
    options.scales = {1.0f, 1.0f};
    const Image image = picture(frame_of(cloud), front_camera(), options);
    EXPECT_EQ(count_near(image, eight_bits(kOrange), 1) + count_near(image, kBackground, 0),
              image.pixels.size());
    return count_near(image, eight_bits(kOrange), 1);
  };
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const std::size_t facing = pixels_of(kFront);
  EXPECT_GT(facing, 100u);
  EXPECT_EQ(pixels_of(-kFront), 0u);
  EXPECT_EQ(pixels_of(glm::vec3(0.0f)), facing);
  EXPECT_EQ(pixels_of(glm::vec3(nan)), facing);
}

TEST_F(RendererTest, TheSignOfAnEstimatedNormalNeitherCullsNorDarkens) {
  for (const DrawMode mode : kModes) {
    DrawOptions options = plain(mode);
    options.lighting = true;
    std::vector<Image> images;
    for (const float sign : {1.0f, -1.0f}) {
      PointCloud cloud;
      add(cloud, glm::vec3(0.04f), sign * glm::normalize(glm::vec3(0.3f, 0.2f, 1.0f)), kOrange,
          0.2f);
      const auto frame = frame_of(cloud);
      frame->normals_estimated = true;
      images.push_back(picture(frame, front_camera(), options));
    }
    EXPECT_EQ(largest_difference(images[0], images[1]), 0) << static_cast<int>(mode);
    EXPECT_LT(count_near(images[0], kBackground, 0), images[0].pixels.size() - 20);
  }
}

TEST_F(RendererTest, ACloudWithoutAnyNormalsOrColoursIsDrawnInGrey) {
  PointCloud cloud;
  cloud.positions = {{0.3f, 0.2f, 0.0f}};
  cloud.radii = {0.1f};
  const auto frame = frame_of(cloud);
  for (const DrawMode mode : kModes) {
    const Image image = picture(frame, front_camera(), plain(mode));
    const glm::ivec2 at = pixel_of(front_camera(), cloud.world(0));
    EXPECT_LE(difference(image.at(at.x, at.y), glm::u8vec3(127)), 1);
  }
}

TEST_F(RendererTest, AbsentColoursAreMadeFromTheNormals) {
  PointCloud cloud;
  const glm::vec3 n = glm::normalize(glm::vec3(0.6f, -0.3f, 0.74f));
  cloud.positions = {{0.3f, 0.2f, 0.0f}};
  cloud.normals = {n};
  cloud.radii = {0.1f};
  const auto frame = frame_of(cloud);
  for (const DrawMode mode : kModes) {
    const Image image = picture(frame, front_camera(), plain(mode));
    const glm::ivec2 at = pixel_of(front_camera(), cloud.world(0));
    const glm::u8vec3 expected(127.5f + 127.5f * n);
    EXPECT_LE(difference(image.at(at.x, at.y), expected), 2) << static_cast<int>(mode);
  }
}

TEST_F(RendererTest, LightMakesWhatFacesItBrighterThanWhatDoesNot) {
  for (const DrawMode mode : kModes) {
    const auto brightness = [&](const glm::vec3& n) {
      PointCloud cloud;
      add(cloud, glm::vec3(0.04f), n, glm::u16vec3(0xc000), 0.2f);
      DrawOptions options = plain(mode);
      options.lighting = true;
      const glm::ivec2 at = pixel_of(front_camera(), cloud.world(0));
      return picture(frame_of(cloud), front_camera(), options).at(at.x, at.y).x;
    };
    EXPECT_GT(brightness(kFront), brightness(glm::normalize(glm::vec3(0.9f, 0.0f, 0.4f))) + 20);
  }
}

TEST_F(RendererTest, AnIsolatedSurfelIsADiscOfItsRadiusSeenAtItsAngle) {
  DrawOptions options = plain(DrawMode::surfel);
  options.scales = {1.0f, 1.0f};
  Camera camera = front_camera();
  const double f = 0.5 * kSize.y / std::tan(0.5 * camera.fov_y) / camera.distance;
  // Looking down at 0.7 rad; the first normal is the pole of the surfel's frame.
  camera.orbit(0.0, 0.7);
  for (const glm::vec3& n : {glm::vec3(0, 1, 0), kFront, glm::normalize(glm::vec3(0.5f, 1, 1)),
                             glm::normalize(glm::vec3(-0.8f, 0.3f, 0.6f))}) {
    PointCloud cloud;
    add(cloud, glm::vec3(0.0f), n, kRed, 0.5f);
    const Image image = picture(frame_of(cloud), camera, options);
    const double area = std::numbers::pi * 0.25 * f * f * glm::dot(glm::dvec3(n), camera.axes()[2]);
    EXPECT_NEAR(static_cast<double>(count_near(image, {255, 0, 0})), area, 0.06 * area);
  }
}

TEST_F(RendererTest, SplatsBlendByWeightInLinearLight) {
  PointCloud cloud;
  add(cloud, {-0.1f, 0.0f, 0.0f}, kFront, kRed, 0.2f);
  add(cloud, {0.1f, 0.0f, 0.0f}, kFront, kGreen, 0.2f);
  const glm::ivec2 size(241, 181);  // a pixel's centre in the middle of both
  const Image image = picture(frame_of(cloud), front_camera(), plain(DrawMode::surfel), size);
  EXPECT_LE(difference(image.at(120, 90), glm::u8vec3(188, 188, 0)), 1);
}

TEST_F(RendererTest, ThousandsOfSplatsOnOnePixelDoNotSaturate) {
  PointCloud cloud;
  for (int i = 0; i < 20000; ++i) add(cloud, glm::vec3(0.0f), kFront, kOrange, 0.05f);
  const Image image = picture(frame_of(cloud), front_camera(), plain(DrawMode::surfel));
  EXPECT_LE(difference(image.at(kSize.x / 2, kSize.y / 2), eight_bits(kOrange)), 1);
}

TEST_F(RendererTest, WhatIsInFrontHidesWhatIsBehindInAnyOrder) {
  for (const bool front_first : {true, false}) {
    PointCloud cloud;
    const auto add_red = [&] { add(cloud, {0.04f, 0.04f, 0.9f}, kFront, kRed, 0.1f); };
    if (front_first) add_red();
    add(cloud, {0.04f, 0.04f, -0.9f}, kFront, kGreen, 0.1f);
    if (!front_first) add_red();
    const glm::ivec2 at = pixel_of(front_camera(), {0.04, 0.04, 0.9});
    for (const DrawMode mode : kModes) {
      const Image image = picture(frame_of(cloud), front_camera(), plain(mode));
      EXPECT_LE(difference(image.at(at.x, at.y), glm::u8vec3(255, 0, 0)), 1)
          << "mode " << static_cast<int>(mode) << " front first " << front_first;
    }
  }
}

TEST_F(RendererTest, OrdersDepthsAHundredThousandTimesTheNearPlaneAway) {
  Camera camera = front_camera();
  camera.distance = 1.0;
  const float far = static_cast<float>(1e5 * camera.near_plane());
  for (const bool front_first : {true, false}) {
    PointCloud cloud;
    const auto add_red = [&] { add(cloud, {0.0f, 0.0f, 1.0f - far}, kFront, kRed, 1.0f); };
    if (front_first) add_red();
    add(cloud, {0.0f, 0.0f, 1.0f - far * 1.0001f}, kFront, kGreen, 0.001f);
    if (!front_first) add_red();
    const auto frame = frame_of(cloud);
    Image image = picture(frame, camera, plain(DrawMode::point));
    EXPECT_LE(difference(image.at(kSize.x / 2, kSize.y / 2), glm::u8vec3(255, 0, 0)), 1);
    // Surfels need more than the tolerance of the visibility pass, twice the radius, between them.
    frame->cloud.positions[front_first ? 1 : 0].z = 1.0f - far * 1.03f;
    frame->cloud.radii[front_first ? 1 : 0] = 1.0f;
    image = picture(frame_of(frame->cloud), camera, plain(DrawMode::surfel));
    EXPECT_LE(difference(image.at(kSize.x / 2, kSize.y / 2), glm::u8vec3(255, 0, 0)), 1);
  }
}

TEST_F(RendererTest, AFloorThatCrossesTheNearPlaneFillsTheLowerHalf) {
  PointCloud cloud;
  add(cloud, {0.0f, -0.5f, 0.0f}, {0.0f, 1.0f, 0.0f}, kGreen, 100.0f);
  Camera camera = front_camera();  // the eye is above the middle of the floor
  const Image image = picture(frame_of(cloud), camera, plain(DrawMode::surfel));
  const std::size_t green = count_near(image, {0, 255, 0}),
                    background = count_near(image, kBackground, 0);
  EXPECT_EQ(green + background, image.pixels.size());
  EXPECT_NEAR(static_cast<double>(green), 0.5 * static_cast<double>(image.pixels.size()),
              0.03 * static_cast<double>(image.pixels.size()));
  EXPECT_LE(difference(image.at(kSize.x / 2, kSize.y - 1), {0, 255, 0}), 2);
  EXPECT_EQ(difference(image.at(kSize.x / 2, 0), kBackground), 0);
}

TEST_F(RendererTest, SurfelsAroundTheEyeAndAtTheEyeLeaveNothingUndefined) {
  PointCloud cloud;
  std::mt19937 random(5);
  std::uniform_real_distribution<float> unit(-0.02f, 0.02f);
  for (int i = 0; i < 300; ++i) {
    const glm::vec3 n(unit(random), unit(random), unit(random));
    add(cloud, glm::vec3(unit(random), unit(random), 4.0f + unit(random)),
        i % 3 ? glm::normalize(n) : glm::vec3(0.0f), kOrange, 0.02f);
  }
  add(cloud, {0.0f, 0.0f, 4.0f}, glm::vec3(0.0f), kOrange, 0.02f);
  const Image image = picture(frame_of(cloud), front_camera(), plain(DrawMode::surfel));
  EXPECT_EQ(count_near(image, eight_bits(kOrange), 2) + count_near(image, kBackground, 0),
            image.pixels.size());
}

TEST_F(RendererTest, VoxelsHaveTheSizeOfTheirLevelAndShowNoGaps) {
  // A full plate of 8 x 8 voxels of the 3-unit cube at depth 5, normals unknown.
  PointCloud cloud;
  const float cell = 3.0f / 32.0f;
  for (int y = -4; y < 4; ++y) {
    for (int x = -4; x < 4; ++x) {
      add(cloud, {(0.5f + static_cast<float>(x)) * cell, (0.5f + static_cast<float>(y)) * cell, 0},
          glm::vec3(0.0f), kRed, 0.1f);
    }
  }
  Camera camera = front_camera();
  const Image image = picture(frame_of(cloud), camera, plain(DrawMode::voxel));
  // The front faces lie at z = one cell (z = 0 is a boundary between cells, the upper one counts).
  const double f = 0.5 * kSize.y / std::tan(0.5 * camera.fov_y) / (camera.distance - cell);
  const double side = 8.0 * cell * f;
  EXPECT_NEAR(static_cast<double>(count_near(image, {255, 0, 0})), side * side, 0.04 * side * side);
  const int half = static_cast<int>(0.5 * side) - 1;
  for (int y = -half; y <= half; ++y) {
    for (int x = -half; x <= half; ++x) {
      ASSERT_LE(difference(image.at(kSize.x / 2 + x, kSize.y / 2 + y), {255, 0, 0}), 2);
    }
  }
}

TEST_F(RendererTest, ACubeShowsItsFacesTowardsTheEyeFromEverySide) {
  PointCloud cloud;
  add(cloud, glm::vec3(0.0f), glm::vec3(0.0f), glm::u16vec3(0xffff), 0.1f);
  const auto frame = frame_of(cloud, 1);  // the voxel from 0 to 1.5
  DrawOptions options = plain(DrawMode::voxel);
  options.lighting = true;
  for (int octant = 0; octant < 8; ++octant) {
    Camera camera = front_camera();
    camera.target = glm::dvec3(0.75);
    camera.distance = 8.0;
    camera.orbit(0.785 + 1.5708 * (octant & 3), octant & 4 ? 0.6 : -0.6);
    const Image image = picture(frame, camera, options);
    // White, dimmed by the light on a face: light from the left and above in the eye's space.
    const glm::dvec3 light = camera.axes() * glm::normalize(glm::dvec3(-0.35, 0.45, 1.0));
    const glm::dvec3 sign = glm::sign(camera.eye() - camera.target);
    for (int axis = 0; axis < 3; ++axis) {
      glm::dvec3 normal(0.0);
      normal[axis] = sign[axis];
      const glm::ivec2 at = pixel_of(camera, camera.target + 0.75 * normal);
      const double linear = 0.4 + 0.6 * std::max(glm::dot(normal, light), 0.0);
      const double srgb = 255.0 * (1.055 * std::pow(linear, 1 / 2.4) - 0.055);
      EXPECT_NEAR(image.at(at.x, at.y).x, srgb, 2.0) << "octant " << octant << " axis " << axis;
    }
  }
}

TEST_F(RendererTest, AStaticSceneIsTheSameByteByByteAndItsCutIsUsedAgain) {
  const auto frame = frame_of(asymmetric_cloud());
  for (const DrawMode mode : kModes) {
    const Image first = picture(frame, front_camera(), plain(mode));
    const DrawStats first_stats = stats_;
    const Image second = picture(frame, front_camera(), plain(mode));
    EXPECT_EQ(largest_difference(first, second), 0);
    EXPECT_EQ(stats_.drawn, first_stats.drawn);
    EXPECT_EQ(stats_.visited, first_stats.visited);
    EXPECT_EQ(stats_.cut_ms, 0.0);
    if (mode == DrawMode::voxel) {
      EXPECT_GT(first_stats.cut_ms, 0.0);
      Camera moved = front_camera();
      moved.orbit(0.3, 0.0);
      EXPECT_GT(largest_difference(second, picture(frame, moved, plain(mode))), 50);
      EXPECT_GT(stats_.cut_ms, 0.0);
    }
  }
}

TEST_F(RendererTest, SurfelsAndPointsOfATreeAreThoseOfItsLeavesAndItsCutIsUsedAgain) {
  const auto leaves = std::make_shared<SceneFrame>(*frame_of(asymmetric_cloud()));
  leaves->cloud = leaf_centers(leaves->svo);
  const auto tree = std::make_shared<SceneFrame>(*leaves);
  tree->cloud = {};
  tree->radii.assign(tree->svo.node_count(), 0.1f);
  for (std::size_t i = tree->svo.internal_count(); i < tree->svo.node_count(); ++i) {
    leaves->cloud.normals.push_back(glm::vec3(tree->attributes.normals[i]) / 32767.0f);
    leaves->cloud.colors.push_back(tree->attributes.colors[i]);
    leaves->cloud.radii.push_back(0.1f);
  }
  for (const DrawMode mode : {DrawMode::surfel, DrawMode::point}) {
    const Image expected = picture(leaves, front_camera(), plain(mode));
    EXPECT_EQ(stats_.visited, 0u);
    const Image drawn = picture(tree, front_camera(), plain(mode));
    EXPECT_LE(largest_difference(expected, drawn), 1);
    EXPECT_EQ(stats_.drawn, tree->svo.leaf_count());
    EXPECT_GT(stats_.cut_ms, 0.0);
    EXPECT_EQ(largest_difference(drawn, picture(tree, front_camera(), plain(mode))), 0);
    EXPECT_EQ(stats_.cut_ms, 0.0);
    EXPECT_EQ(stats_.visited, tree->svo.node_count());

    // From far away they are one, and from beside the picture none.
    Camera far = front_camera();
    far.distance = 1e4;
    picture(tree, far, plain(mode));
    EXPECT_EQ(stats_.drawn, 1u);
    EXPECT_EQ(stats_.below_pixel, tree->svo.leaf_count() - 1);
    EXPECT_EQ(stats_.out_of_view, 0u);
    Camera beside = front_camera();
    beside.target.x += 100.0;
    picture(tree, beside, plain(mode));
    EXPECT_EQ(stats_.drawn, 0u);
    EXPECT_EQ(stats_.out_of_view, tree->svo.leaf_count());
    EXPECT_EQ(stats_.below_pixel, 0u);
  }
}

TEST_F(RendererTest, TheOrderOfTheSurfelsChangesAtMostOneStepOfAColour) {
  std::mt19937 random(9);
  std::normal_distribution<float> normal;
  PointCloud cloud, shuffled;
  // So many that holes are found by some of the backs only.
  for (int i = 0; i < 40000; ++i) {
    const glm::vec3 n = glm::normalize(glm::vec3(normal(random), normal(random), normal(random)));
    add(cloud, n, n, glm::u16vec3(random(), random(), random()), 0.012f);
  }
  std::vector<std::size_t> order(cloud.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::shuffle(order.begin(), order.end(), random);
  for (const std::size_t i : order) {
    add(shuffled, cloud.positions[i], cloud.normals[i], cloud.colors[i], cloud.radii[i]);
  }
  const Image a = picture(frame_of(cloud), front_camera(), plain(DrawMode::surfel));
  const Image b = picture(frame_of(shuffled), front_camera(), plain(DrawMode::surfel));
  EXPECT_LT(count_near(a, kBackground, 0), a.pixels.size() * 3 / 4);
  EXPECT_LE(largest_difference(a, b), 1);
}

/// Some facing away, some of unknown orientation, more than a batch of uniform buffers holds.
PointCloud prickly_sphere(int points, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<float> normal;
  PointCloud cloud;
  for (int i = 0; i < points; ++i) {
    const glm::vec3 n = glm::normalize(glm::vec3(normal(random), normal(random), normal(random)));
    const glm::vec3 towards =
        glm::normalize(n + 0.5f * glm::vec3(normal(random), normal(random), normal(random)));
    add(cloud, n, i % 17 == 0 ? glm::vec3(0.0f) : towards,
        glm::u16vec3(random(), random(), random()), 0.04f);
  }
  return cloud;
}

/// Share of the pixels that are not the same but for rounding.
double share_different(const Image& a, const Image& b, int but_for = 2) {
  std::size_t different = 0;
  for (std::size_t i = 0; i < a.pixels.size(); ++i)
    different += difference(a.pixels[i], b.pixels[i]) > but_for ? 1u : 0u;
  return static_cast<double>(different) / static_cast<double>(a.pixels.size());
}

TEST_F(RendererTest, EveryMethodOfInstancingDrawsTheSamePicture) {
  const auto frame = frame_of(prickly_sphere(5000, 3));
  auto estimated = frame_of(prickly_sphere(3000, 4));
  estimated->normals_estimated = true;
  Camera close = front_camera();
  close.distance = 0.9;  // inside the sphere: surfels behind the eye and across the near plane
  Camera far = front_camera();
  far.distance = 9.0;
  for (const Splatting splatting :
       {Splatting::normalized, Splatting::two_pass, Splatting::no_depth}) {
    for (const Camera& camera : {front_camera(), close, far}) {
      DrawOptions options = plain(DrawMode::surfel);
      options.lighting = true;
      options.splatting = splatting;
      options.instancing = Instancing::attribute;
      const Image one = picture(frame, camera, options);
      const Image two = picture(estimated, camera, options);
      EXPECT_LT(count_near(one, kBackground, 0), one.pixels.size() * 24 / 25);
      EXPECT_GT(share_different(one, two), 0.04);
      for (const Instancing other :
           {Instancing::geometry, Instancing::uniform, Instancing::texture}) {
        options.instancing = other;
        EXPECT_LT(share_different(one, picture(frame, camera, options)), 0.001) << name(other);
        EXPECT_LT(share_different(two, picture(estimated, camera, options)), 0.001) << name(other);
      }
    }
  }
}

/// Of a colour that changes slowly, so that pixels at the rims of single surfels do not matter.
PointCloud smooth_sphere(int points) {
  PointCloud cloud = prickly_sphere(points, 8);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const glm::vec3 p = cloud.positions[i];
    if (cloud.normals[i] != glm::vec3(0.0f))
      cloud.normals[i] = glm::normalize(cloud.normals[i] + 3.0f * p);
    cloud.colors[i] = glm::u16vec3(32767.0f * (1.0f + p));
  }
  return cloud;
}

TEST_F(RendererTest, PulledPointsLookLikeQuads) {
  const auto frame = frame_of(smooth_sphere(20000));
  auto estimated = frame_of(smooth_sphere(20000));
  estimated->normals_estimated = true;
  // From mere points to nothing but quads, and some of both.
  for (const double distance : {12.0, 6.0, 3.0, 1.5, 1.05, 0.5}) {
    Camera camera = front_camera();
    camera.distance = distance;
    for (const auto& drawn : {frame, estimated}) {
      DrawOptions options = plain(DrawMode::surfel);
      options.lighting = true;
      options.instancing = Instancing::attribute;
      const Image quads = picture(drawn, camera, options);
      EXPECT_LT(count_near(quads, kBackground, 0), quads.pixels.size() * 39 / 40);
      options.instancing = Instancing::pull;
      EXPECT_LT(share_different(quads, picture(drawn, camera, options), 8), 0.005) << distance;
    }
  }
}

TEST_F(RendererTest, EveryMethodOfInstancingDrawsTheSameVoxels) {
  const auto frame = frame_of(prickly_sphere(5000, 5), 6);
  for (const VoxelShape shape : {VoxelShape::faces, VoxelShape::cube}) {
    DrawOptions options = plain(DrawMode::voxel);
    options.lighting = true;
    options.voxel_shape = VoxelShape::faces;
    options.instancing = Instancing::attribute;
    const Image one = picture(frame, front_camera(), options);
    options.voxel_shape = shape;
    for (const Instancing other : {Instancing::geometry, Instancing::uniform, Instancing::texture,
                                   Instancing::attribute, Instancing::pull}) {
      options.instancing = other;
      EXPECT_LT(share_different(one, picture(frame, front_camera(), options)), 0.001)
          << name(other);
    }
  }
}

TEST_F(RendererTest, LeavesOutVoxelsThatOthersHideAndDrawsTheSamePicture) {
  PointCloud cloud;
  std::mt19937 random(6);
  for (int i = 0; i < 20 * 20 * 20; ++i) {
    const glm::ivec3 cell(i % 20, i / 20 % 20, i / 400);
    if (random() % 8 == 0) continue;
    add(cloud, glm::vec3(cell - 10) * (3.0f / 32) + 0.05f, glm::vec3(0.0f),
        glm::u16vec3(random(), random(), random()), 0.1f);
  }
  const auto all = frame_of(cloud, 5);
  auto some = frame_of(cloud, 5);
  some->neighbors = leaf_neighbors(some->svo);
  for (int corner = 0; corner < 8; ++corner) {
    Camera camera = front_camera();
    camera.orbit(0.785 + 1.5708 * (corner & 3), corner & 4 ? 0.6 : -0.6);
    const Image one = picture(all, camera, plain(DrawMode::voxel));
    const std::uint32_t drawn = stats_.drawn;
    EXPECT_EQ(stats_.hidden, 0u);
    const Image two = picture(some, camera, plain(DrawMode::voxel));
    EXPECT_EQ(largest_difference(one, two), 0);
    EXPECT_LT(stats_.drawn, drawn / 2);
    EXPECT_EQ(stats_.drawn + stats_.hidden, drawn);
  }
  // Surfels of the same tree are all drawn.
  some->cloud = {};
  picture(some, front_camera(), plain(DrawMode::surfel));
  EXPECT_EQ(stats_.hidden, 0u);
}

TEST_F(RendererTest, CoversWhatItDrawsAndNothingElse) {
  for (const DrawMode mode : kModes) {
    const Image image = picture(frame_of(asymmetric_cloud()), front_camera(), plain(mode));
    const auto alpha = renderer_->read_alpha();
    ASSERT_TRUE(alpha);
    ASSERT_EQ(alpha->size(), image.pixels.size());
    for (std::size_t i = 0; i < alpha->size(); ++i)
      ASSERT_EQ((*alpha)[i] > 0, difference(image.pixels[i], kBackground) > 0);
  }
}

TEST_F(RendererTest, NothingIsLeftOfALargerFrameAnotherModeOrAnotherSize) {
  std::mt19937 random(2);
  std::uniform_real_distribution<float> unit(-1.0f, 1.0f);
  PointCloud large;
  for (int i = 0; i < 1000; ++i) {
    add(large, {unit(random), unit(random), unit(random)}, kFront, kGreen, 0.1f);
  }
  const auto small = frame_of(asymmetric_cloud());
  for (const DrawMode mode : kModes) {
    const Image before = picture(small, front_camera(), plain(mode));
    for (const DrawMode other : kModes) {
      picture(frame_of(large), front_camera(), plain(other), {64, 300});
      EXPECT_EQ(largest_difference(before, picture(small, front_camera(), plain(mode))), 0);
      picture(small, front_camera(), plain(other));
      EXPECT_EQ(largest_difference(before, picture(small, front_camera(), plain(mode))), 0);
    }
  }
}

TEST_F(RendererTest, PresentsTheSameBytesThatItReads) {
  gl::Texture color = gl::make_texture(GL_RGBA8, kSize.x, kSize.y);
  gl::Texture depth = gl::make_texture(GL_DEPTH_COMPONENT32F, kSize.x, kSize.y);
  const Result<gl::Framebuffer> target = gl::make_framebuffer(color, depth);
  ASSERT_TRUE(target);
  const auto expect_the_same = [&](const Image& image) {
    renderer_->present(target->name());
    std::vector<glm::u8vec3> bottom_up(image.pixels.size());
    glPixelStorei(GL_PACK_ALIGNMENT, 1);
    glGetTextureImage(color.name(), 0, GL_RGB, GL_UNSIGNED_BYTE,
                      static_cast<GLsizei>(bottom_up.size() * 3), bottom_up.data());
    for (int y = 0; y < kSize.y; ++y) {
      for (int x = 0; x < kSize.x; ++x) {
        const auto i = static_cast<std::size_t>((kSize.y - 1 - y) * kSize.x + x);
        ASSERT_EQ(difference(image.at(x, y), bottom_up[i]), 0);
      }
    }
  };
  // Large and small, and partly out of the picture.
  Camera near = front_camera();
  near.distance *= 0.3;
  Camera far = front_camera();
  far.distance *= 20.0;
  const auto frame = frame_of(asymmetric_cloud());
  for (const Camera& camera : {front_camera(), near, far}) {
    for (const DrawMode mode : kModes) {
      DrawOptions options = plain(mode);
      options.background = {0.37f, 0.51f, 0.83f};
      expect_the_same(picture(frame, camera, options));
      options.point_size = 31.0f;
      options.splatting = Splatting::enlarged;
      expect_the_same(picture(frame, camera, options));
      options.floor = FloorGrid{{glm::dvec3(-1.0), glm::dvec3(1.0)}, 'y'};
      expect_the_same(picture(frame, camera, options));
    }
  }
  expect_the_same(picture(nullptr, front_camera(), plain(DrawMode::surfel)));
}

TEST_F(RendererTest, ColoursAreTheFramesOrMadeFromNormalsOrNone) {
  PointCloud cloud = asymmetric_cloud();
  const glm::vec3 askew = glm::normalize(glm::vec3(0.3f, -0.2f, 1.0f));
  for (glm::vec3& normal : cloud.normals) normal = askew;
  const auto frame = frame_of(cloud);
  const glm::u8vec3 of_normal(glm::round((askew + 1.0f) * 127.5f)), plain_color(0xd0);
  for (const DrawMode mode : kModes) {
    DrawOptions options = plain(mode);
    const Image own = picture(frame, front_camera(), options);
    options.color = ColorSource::normals;
    const Image normals = picture(frame, front_camera(), options);
    options.color = ColorSource::plain;
    const Image gray = picture(frame, front_camera(), options);
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      const glm::ivec2 at = pixel_of(front_camera(), cloud.world(i));
      EXPECT_LE(difference(own.at(at.x, at.y), eight_bits(cloud.colors[i])), 2);
      EXPECT_LE(difference(normals.at(at.x, at.y), of_normal), 2) << static_cast<int>(mode);
      EXPECT_LE(difference(gray.at(at.x, at.y), plain_color), 2);
    }
    options.color = ColorSource::colors;
    EXPECT_EQ(largest_difference(own, picture(frame, front_camera(), options)), 0);
  }
}

TEST_F(RendererTest, KnowsWhereInTheWorldAPixelLies) {
  for (const glm::dvec3& offset : {glm::dvec3(0.0), glm::dvec3(4e6, -7e6, 2e5)}) {
    auto frame = frame_of(asymmetric_cloud());
    frame->cloud.origin += offset;
    frame->svo.cube.origin += offset;
    for (const char up : {'y', 'z'}) {
      Camera camera = front_camera();
      camera.target += offset;
      camera.up = up;
      camera.orbit(0.2, up == 'z' ? 1.4 : 0.1);
      std::vector<DrawOptions> ways = {plain(DrawMode::voxel), plain(DrawMode::point)};
      for (int i = 0; i < kSplattings; ++i) {
        ways.push_back(plain(DrawMode::surfel));
        ways.back().splatting = static_cast<Splatting>(i);
      }
      for (const DrawOptions& options : ways) {
        picture(frame, camera, options);
        for (std::size_t i = 0; i < frame->cloud.size(); ++i) {
          const glm::dvec3 world = frame->cloud.world(i);
          const glm::ivec2 at = pixel_of(camera, world);
          // Half a voxel's diagonal, or what surfels are pushed back by; both are about 0.1.
          const auto found = renderer_->point_at(glm::dvec2(at) + 0.5);
          ASSERT_TRUE(found) << name(options.splatting);
          EXPECT_LT(glm::distance(*found, world), 0.21) << name(options.splatting);
          const glm::ivec2 again = pixel_of(camera, *found);
          EXPECT_LE(std::max(std::abs(again.x - at.x), std::abs(again.y - at.y)), 1);
        }
        EXPECT_FALSE(renderer_->point_at({3.0, 3.0}));
      }
    }
  }
}

TEST_F(RendererTest, TheNearestPixelThatShowsAnythingIsTakenForOneBesideIt) {
  PointCloud cloud;
  add(cloud, {0.3f, 0.2f, 0.1f}, kFront, kRed, 0.1f);
  const auto frame = frame_of(cloud);
  DrawOptions options = plain(DrawMode::point);
  const glm::ivec2 at = pixel_of(front_camera(), cloud.world(0));
  picture(frame, front_camera(), options);
  for (const glm::ivec2& beside : {glm::ivec2(6, 0), glm::ivec2(-6, 0), glm::ivec2(0, 7)}) {
    const auto found = renderer_->point_at(glm::dvec2(at + beside) + 0.5);
    ASSERT_TRUE(found);
    const glm::ivec2 seen = pixel_of(front_camera(), *found);
    // The point is a square of five pixels.
    EXPECT_LE(std::max(std::abs(seen.x - at.x), std::abs(seen.y - at.y)), 3);
    EXPECT_NEAR(found->z, 0.1, 1e-5);
  }
  EXPECT_FALSE(renderer_->point_at(glm::dvec2(at) + 30.0));
  // Of the last picture, whatever its size; and nothing outside of it.
  picture(frame, front_camera(), options, {100, 400});
  EXPECT_TRUE(
      renderer_->point_at(glm::dvec2(pixel_of(front_camera(), cloud.world(0), {100, 400})) + 0.5));
  for (const glm::dvec2& outside :
       {glm::dvec2(-1.0, 50.0), glm::dvec2(50.0, -1.0), glm::dvec2(101.0, 50.0),
        glm::dvec2(50.0, 401.0), glm::dvec2(std::nan(""), 50.0), glm::dvec2(1e300, 1e300)})
    EXPECT_FALSE(renderer_->point_at(outside));
  picture(nullptr, front_camera(), options, {1, 1});
  EXPECT_FALSE(renderer_->point_at({0.5, 0.5}));
}

TEST_F(RendererTest, ThePictureIsATextureOfTheSameBytes) {
  EXPECT_EQ(renderer_->texture(), 0u);
  EXPECT_FALSE(renderer_->point_at({1.0, 1.0}));
  for (const glm::ivec2& size : {kSize, glm::ivec2(33, 57)}) {
    const Image image =
        picture(frame_of(asymmetric_cloud()), front_camera(), plain(DrawMode::surfel), size);
    const GLuint texture = renderer_->texture();
    GLint format = 0, alpha = 0, width = 0;
    glGetTextureLevelParameteriv(texture, 0, GL_TEXTURE_INTERNAL_FORMAT, &format);
    glGetTextureLevelParameteriv(texture, 0, GL_TEXTURE_WIDTH, &width);
    glGetTextureParameteriv(texture, GL_TEXTURE_SWIZZLE_A, &alpha);
    EXPECT_EQ(format, GL_RGBA8);
    EXPECT_EQ(alpha, GL_ONE);
    ASSERT_EQ(width, size.x);
    std::vector<glm::u8vec4> bottom_up(image.pixels.size());
    glPixelStorei(GL_PACK_ALIGNMENT, 1);
    glGetTextureImage(texture, 0, GL_RGBA, GL_UNSIGNED_BYTE,
                      static_cast<GLsizei>(bottom_up.size() * 4), bottom_up.data());
    for (int y = 0; y < size.y; ++y) {
      for (int x = 0; x < size.x; ++x) {
        const auto i = static_cast<std::size_t>((size.y - 1 - y) * size.x + x);
        ASSERT_EQ(difference(image.at(x, y), glm::u8vec3(bottom_up[i])), 0);
      }
    }
  }
}

TEST_F(RendererTest, ASecondRendererInTheSameContextDrawsTheSame) {
  const auto frame = frame_of(asymmetric_cloud());
  const Image first = picture(frame, front_camera(), plain(DrawMode::point));
  auto second = Renderer::create();
  ASSERT_TRUE(second);
  ASSERT_TRUE(second->draw(frame, front_camera(), kSize / 2, plain(DrawMode::surfel)));
  ASSERT_TRUE(second->draw(frame, front_camera(), kSize, plain(DrawMode::point)));
  EXPECT_EQ(largest_difference(first, *second->read_pixels()), 0);
  EXPECT_EQ(largest_difference(first, picture(frame, front_camera(), plain(DrawMode::point))), 0);
}

TEST_F(RendererTest, RefusesAPictureThatIsTooLargeAndReadsNoneBeforeTheFirst) {
  EXPECT_FALSE(renderer_->read_pixels());
  EXPECT_FALSE(renderer_->draw(nullptr, Camera{}, {0, 100}, DrawOptions{}));
  const Result<DrawStats> huge = renderer_->draw(nullptr, Camera{}, {1 << 24, 1}, DrawOptions{});
  ASSERT_FALSE(huge);
  EXPECT_NE(huge.error().message.find("16777216x1"), std::string::npos);
}

TEST_F(RendererTest, AMissingShaderIsAnErrorThatNamesIt) {
  const auto program_of = [](std::string_view vertex) {
    return gl::make_program(std::array{gl::Stage{GL_VERTEX_SHADER, {vertex}},
                                       gl::Stage{GL_FRAGMENT_SHADER, {"shaders/flat.frag.glsl"}}});
  };
  const Result<gl::Program> program = program_of("absent.glsl");
  ASSERT_FALSE(program);
  EXPECT_NE(program.error().message.find("absent.glsl"), std::string::npos);
  // What all stages share comes first, so this is there twice; the compiler's words come through.
  const Result<gl::Program> wrong = program_of("shaders/common.glsl");
  ASSERT_FALSE(wrong);
  EXPECT_NE(wrong.error().message.find("common.glsl does not compile: "), std::string::npos)
      << wrong.error().message;
  EXPECT_EQ(wrong.error().message.find('\n'), std::string::npos);

  gl::LateProgram late({{GL_VERTEX_SHADER, {"absent.glsl"}}});
  for (int twice = 0; twice < 2; ++twice) {
    const auto used = late.use();
    ASSERT_FALSE(used);
    EXPECT_NE(used.error().message.find("absent.glsl"), std::string::npos);
  }
}

TEST(Image, IsWrittenAsPngTopRowFirstAndAnUnwritablePathIsNamed) {
  Image image{3, 2, {}};
  image.pixels = {{255, 0, 0}, {0, 255, 0}, {0, 0, 255}, {1, 2, 3}, {4, 5, 6}, {250, 128, 7}};
  const std::string path =
      (std::filesystem::temp_directory_path() / "pointreel-image-test.png").string();
  const Result<void> written = write_png(path, image);
  ASSERT_TRUE(written) << written.error().message;
  png_image png{};
  png.version = PNG_IMAGE_VERSION;
  ASSERT_TRUE(png_image_begin_read_from_file(&png, path.c_str()));
  ASSERT_EQ(png.width, 3u);
  ASSERT_EQ(png.height, 2u);
  png.format = PNG_FORMAT_RGB;
  std::vector<glm::u8vec3> pixels(6);
  ASSERT_TRUE(png_image_finish_read(&png, nullptr, pixels.data(), 0, nullptr));
  EXPECT_EQ(pixels, image.pixels);
  std::filesystem::remove(path);

  const Result<void> refused = write_png("/nonexistent/folder/x.png", image);
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("/nonexistent/folder/x.png"), std::string::npos);
}

}  // namespace
}  // namespace pointreel
