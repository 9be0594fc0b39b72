#include "client/render/scene_instances.h"

#include <algorithm>
#include <cstdlib>
#include <memory>
#include <utility>

#include <gtest/gtest.h>

#include "codec/core/build.h"
#include "tests/client/drawing_test.h"

namespace pointreel::scene_instances_test {
namespace {

constexpr glm::ivec2 kSize(240, 180);
constexpr DrawMode kModes[] = {DrawMode::surfel, DrawMode::voxel, DrawMode::point};
/// A whole number of cells of the cubes below, so that moved voxels lie on the same lattice.
constexpr double kShift = 0.75;

/// Adds a 6 x 6 tile of coloured points around `center`. All tiles fit into the cubes below.
void add_tile(PointCloud& cloud, const glm::vec3& center, const glm::u16vec3& color) {
  for (int i = 0; i < 36; ++i) {
    cloud.positions.push_back(center + 0.09375f * glm::vec3(i % 6 - 3, i / 6 - 3, 0.0f) + 0.02f);
    cloud.normals.emplace_back(0.0f, 0.0f, 1.0f);
    cloud.colors.push_back(color);
    cloud.radii.push_back(0.06f);
  }
}

/// `with_cloud`: drawn as points. Otherwise it is drawn as a tree in every mode.
std::shared_ptr<SceneFrame> frame_of(PointCloud cloud, bool with_cloud) {
  auto frame = std::make_shared<SceneFrame>();
  const SortedPoints sorted = sort_points(cloud, {glm::dvec3(-1.5), 3.0});
  frame->svo = build_svo(sorted, 5);
  frame->attributes = mean_attributes(frame->svo, cloud, sorted);
  if (with_cloud) frame->cloud = std::move(cloud);
  return frame;
}

DrawOptions unlit(DrawMode mode) {
  DrawOptions options;
  options.mode = mode;
  options.lighting = false;
  options.pixel_size = 0.0f;
  options.point_size = 12.0f;  // leaves no gaps in a tile
  return options;
}

std::size_t different_pixels(const Image& a, const Image& b) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < a.pixels.size(); ++i) {
    const glm::ivec3 d = glm::abs(glm::ivec3(a.pixels[i]) - glm::ivec3(b.pixels[i]));
    count += std::max({d.x, d.y, d.z}) > 2;
  }
  return count;
}

class SceneInstancesTest : public DrawingTest {
 protected:
  Camera camera_ = [] {
    Camera camera;
    camera.distance = 4.0;
    return camera;
  }();
};

INSTANTIATE_TEST_SUITE_P(, SceneInstancesTest, kBothRenderers, renderer_name);

TEST_P(SceneInstancesTest, two_frames_at_their_places_look_like_one_frame_with_both) {
  const glm::u16vec3 red(0xffff, 0, 0), blue(0, 0, 0xffff);
  PointCloud left, right, both;
  add_tile(left, glm::vec3(0.0f), red);
  add_tile(right, glm::vec3(0.0f), blue);
  add_tile(both, glm::vec3(static_cast<float>(-kShift), 0.0f, 0.0f), red);
  add_tile(both, glm::vec3(static_cast<float>(kShift), 0.0f, 0.0f), blue);
  for (const bool with_cloud : {true, false}) {
    const Scene apart = {{frame_of(left, with_cloud), {-kShift, 0.0, 0.0}},
                         {frame_of(right, with_cloud), {kShift, 0.0, 0.0}}};
    const auto together = frame_of(both, with_cloud);
    for (const DrawMode mode : kModes) {
      const Image expected = draw(together, camera_, kSize, unlit(mode));
      const DrawStats expected_stats = stats_;
      const Image image = draw(apart, camera_, kSize, unlit(mode));
      EXPECT_LE(different_pixels(image, expected), 4u) << static_cast<int>(mode) << with_cloud;
      EXPECT_EQ(stats_.drawn, expected_stats.drawn);
      EXPECT_GT(stats_.drawn, 40u);
    }
  }
}

TEST_P(SceneInstancesTest, near_frames_hide_far_ones_in_any_order) {
  PointCloud tile, other;
  add_tile(tile, glm::vec3(0.0f), {0xffff, 0, 0});
  add_tile(other, glm::vec3(0.0f), {0, 0xffff, 0});
  const PlacedFrame near{frame_of(tile, true), {0.0, 0.0, 1.0}};
  const PlacedFrame far{frame_of(other, true), {0.0, 0.0, -1.0}};
  for (const DrawMode mode : kModes) {
    for (const Scene& scene : {Scene{near, far}, Scene{far, near}}) {
      const Image image = draw(scene, camera_, kSize, unlit(mode));
      const glm::ivec3 middle(image.at(kSize.x / 2, kSize.y / 2));
      EXPECT_GT(middle.x, 200) << static_cast<int>(mode);
      EXPECT_LT(middle.y, 40) << static_cast<int>(mode);
    }
  }
}

TEST_P(SceneInstancesTest, a_missing_frame_draws_nothing) {
  PointCloud tile;
  add_tile(tile, glm::vec3(0.0f), {0xffff, 0, 0});
  const auto frame = frame_of(tile, false);
  for (const DrawMode mode : kModes) {
    const Image alone = draw(frame, camera_, kSize, unlit(mode));
    const std::uint32_t drawn = stats_.drawn;
    const Image image =
        draw(Scene{{nullptr, {5.0, 0.0, 0.0}}, {frame}}, camera_, kSize, unlit(mode));
    EXPECT_EQ(different_pixels(image, alone), 0u);
    EXPECT_EQ(stats_.drawn, drawn);
  }
}

TEST_P(SceneInstancesTest, gaps_between_voxels_are_filled_or_left_by_the_options) {
  PointCloud net;
  for (int i = 0; i < 18 * 18; ++i) {
    const int x = i % 18, y = i / 18;
    if (x % 3 != 0 && y % 3 != 0) continue;
    net.positions.push_back(0.09375f * glm::vec3(x - 8, y - 8, 0.0f) + 0.02f);
    net.colors.emplace_back(0xffff, 0, 0);
  }
  const auto open = frame_of(net, false);
  auto filled = std::make_shared<SceneFrame>(*open);
  filled->filled = fill_gaps(filled->svo, filled->attributes, 3);
  filled->neighbors = leaf_neighbors(filled->svo);
  for (const float pixel_size : {0.0f, 8.0f}) {  // leaves, and nodes above them
    DrawOptions options = unlit(DrawMode::voxel);
    options.pixel_size = pixel_size;
    const Image closed = draw(filled, camera_, kSize, options);
    options.fill_holes = false;
    const Image left = draw(filled, camera_, kSize, options);
    const Image expected = draw(open, camera_, kSize, options);
    EXPECT_EQ(different_pixels(left, expected), 0u) << pixel_size;
    if (pixel_size > 0.0f) continue;
    EXPECT_GT(different_pixels(left, closed), 1000u);
    // There are no open gaps in the middle of the net.
    for (int y = 70; y < 110; ++y) {
      for (int x = 100; x < 140; ++x) ASSERT_GT(closed.at(x, y).x, 200) << x << ", " << y;
    }
  }
}

TEST_P(SceneInstancesTest, a_moved_frame_is_redrawn) {
  PointCloud tile;
  add_tile(tile, glm::vec3(0.0f), {0xffff, 0, 0});
  const auto frame = frame_of(tile, true);
  for (const DrawMode mode : kModes) {
    const Image before = draw(Scene{{frame}}, camera_, kSize, unlit(mode));
    const Image after = draw(Scene{{frame, {0.5, 0.0, 0.0}}}, camera_, kSize, unlit(mode));
    EXPECT_GT(different_pixels(before, after), 100u) << static_cast<int>(mode);
  }
}

}  // namespace
}  // namespace pointreel::scene_instances_test
