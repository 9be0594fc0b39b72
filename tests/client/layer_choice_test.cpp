#include "client/prepare/layer_choice.h"

#include <gtest/gtest.h>

#include "codec/core/build.h"

namespace pointreel::layer_choice_test {
namespace {

Manifest reel(int depth, bool colors = true) {
  Manifest manifest;
  manifest.codec = "octree";
  manifest.colors = colors;
  manifest.normals = true;
  manifest.depth_min = manifest.depth_max = static_cast<std::uint32_t>(depth);
  manifest.bounds = {{-0.3, 0.0, -0.3}, {0.3, 1.8, 0.3}};
  manifest.layer_names = {"base", "middle", "full"};
  Segment segment;
  segment.cube = {{-0.9, 0.0, -0.9}, 1.8};
  manifest.segments.push_back(segment);
  return manifest;
}

TEST(LayerChoice, includes_the_layers_down_to_the_level) {
  const Manifest manifest = reel(10);
  for (const auto& [level, layers] :
       {std::pair{0, 1u}, {5, 1u}, {7, 1u}, {8, 2u}, {9, 2u}, {10, 3u}, {kWholeFrame, 3u}}) {
    EXPECT_EQ(layer_choice(manifest, DrawMode::voxel, level).end, layers) << level;
  }
  EXPECT_EQ(layer_choice(reel(6), DrawMode::voxel, kWholeFrame).end, 1u);
  EXPECT_EQ(layer_choice(reel(9), DrawMode::voxel, kWholeFrame).end, 2u);
}

TEST(LayerChoice, includes_normals_only_if_they_are_visible) {
  EXPECT_TRUE(layer_choice(reel(10), DrawMode::surfel, 10).normals);
  EXPECT_FALSE(layer_choice(reel(10), DrawMode::voxel, 10).normals);
  EXPECT_FALSE(layer_choice(reel(10), DrawMode::point, 10).normals);
  EXPECT_TRUE(layer_choice(reel(10, false), DrawMode::voxel, 10).normals);
  EXPECT_TRUE(layer_choice(reel(10, false), DrawMode::point, 10).normals);
  EXPECT_TRUE(layer_choice(reel(10), DrawMode::voxel, 10).colors);
  EXPECT_TRUE(layer_choice(reel(10), DrawMode::voxel, 10, true).normals);
  EXPECT_TRUE(layer_choice(reel(10), DrawMode::point, 10, true).normals);
}

TEST(LayerChoice, leaves_codecs_without_layers_whole) {
  Manifest manifest = reel(11);
  manifest.codec = "draco";
  EXPECT_EQ(layer_choice(manifest, DrawMode::point, 3).end, kAllLayers);
  manifest.codec = "files";
  EXPECT_EQ(layer_choice(manifest, DrawMode::point, 3).end, kAllLayers);
}

TEST(LayerChoice, follows_the_height_of_a_person_in_pixels) {
  const Manifest manifest = reel(12);
  Camera camera;
  camera.frame_bounds(manifest.bounds, 1.0);
  const auto layers = [&](int height) {
    const int level = level_for(manifest, camera, glm::ivec2(height), 1.0f);
    return layer_choice(manifest, DrawMode::surfel, level).end;
  };
  EXPECT_EQ(layers(90), 1u);
  EXPECT_EQ(layers(300), 2u);
  EXPECT_EQ(layers(700), 3u);
  camera.zoom(0.1);
  EXPECT_EQ(layers(100), 3u) << "close-ups need all";
}

TEST(LevelFor, depends_on_the_largest_cube_of_the_reel) {
  Manifest manifest = reel(12);
  Camera camera;
  camera.frame_bounds(manifest.bounds, 1.0);
  const int level = level_for(manifest, camera, glm::ivec2(300), 1.0f);
  Segment larger = manifest.segments[0];
  larger.cube.edge *= 4.0;
  manifest.segments.push_back(larger);
  EXPECT_EQ(level_for(manifest, camera, glm::ivec2(300), 1.0f), level + 2);
}

SceneFrame frame_of(int depth, int level) {
  PointCloud cloud;
  cloud.positions = {glm::vec3(0.5f)};
  SceneFrame frame;
  frame.svo = build_svo(sort_points(cloud, Cube{}), depth);
  frame.level = level;
  return frame;
}

TEST(VoxelDepth, is_that_of_the_deepest_frame_so_far_or_more_if_frames_lack_levels) {
  VoxelDepth depth;
  EXPECT_EQ(depth.get(), kWholeFrame) << "nothing is known";
  depth.learn(SceneFrame{});
  EXPECT_EQ(depth.get(), kWholeFrame) << "an empty frame tells nothing";
  depth.learn(frame_of(8, kWholeFrame));
  EXPECT_EQ(depth.get(), 8);
  depth.learn(frame_of(6, kWholeFrame));
  EXPECT_EQ(depth.get(), 8);
  depth.learn(frame_of(9, 9));
  EXPECT_EQ(depth.get(), 10);
  depth.learn(frame_of(10, kWholeFrame));
  EXPECT_EQ(depth.get(), 10);
}

TEST(LayerChoice, takes_all_layers_where_a_scalar_field_is_shown) {
  EXPECT_EQ(layer_choice(reel(10), DrawMode::surfel, 3, false, true).end, kAllLayers);
}

}  // namespace
}  // namespace pointreel::layer_choice_test
