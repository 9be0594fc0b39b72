#include "client/prepare/prepare.h"

#include <cmath>
#include <random>
#include <string>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "client/scene/scalar_colors.h"
#include "codec/files/ply.h"
#include "pointreel/chunks.h"
#include "pointreel/draco.h"

namespace pointreel::prepare_test {
namespace {

/// Points on a sphere of radius 1 about (10, 0, 0).
PointCloud sphere(std::size_t points, bool normals, bool colors) {
  std::mt19937 random(7);
  std::normal_distribution<float> gauss;
  PointCloud cloud;
  cloud.origin = {10.0, 0.0, 0.0};
  for (std::size_t i = 0; i < points; ++i) {
    const glm::vec3 n = glm::normalize(glm::vec3(gauss(random), gauss(random), gauss(random)));
    cloud.positions.push_back(n);
    if (normals) cloud.normals.push_back(n);
    if (colors)
      cloud.colors.push_back(n.x > 0 ? glm::u16vec3(65535, 0, 0) : glm::u16vec3(0, 0, 65535));
  }
  return cloud;
}

const Cube kCube{{8.5, -1.5, -1.5}, 3.0};

Manifest manifest_of(const PointCloud& cloud) {
  Manifest manifest;
  manifest.colors = cloud.has_colors();
  manifest.normals = cloud.has_normals();
  Segment segment;
  segment.cube = kCube;
  segment.times_us = {0, 40'000};
  manifest.segments.push_back(segment);
  return manifest;
}

FetchedFrame fetched(const PointCloud& cloud, const EncodeOptions& options) {
  const auto encoded = encode_frame(cloud, kCube, options);
  EXPECT_TRUE(encoded);
  FetchedFrame frame;
  for (const Chunks<Bytes>& layer : encoded->layers) {
    FetchedLayer out;
    Bytes bytes;
    for (const Bytes* chunk : {&layer.geometry, &layer.colors, &layer.normals})
      bytes.insert(bytes.end(), chunk->begin(), chunk->end());
    out.bytes = std::move(bytes);
    out.sizes = {static_cast<std::uint32_t>(layer.geometry.size()),
                 static_cast<std::uint32_t>(layer.colors.size()),
                 static_cast<std::uint32_t>(layer.normals.size())};
    frame.layers.push_back(std::move(out));
  }
  return frame;
}

Result<SceneFrame> prepare_frame(const Manifest& manifest, std::uint32_t index,
                                 const FetchedFrame& frame, const PrepareOptions& options) {
  return pointreel::prepare_frame(frame, frame_info(manifest, index), options);
}

EncodeOptions octree(double delta) {
  OctreeOptions options;
  options.depth = DepthRule::by_delta(delta);
  return {options};
}

FetchedFrame ply(const PointCloud& cloud) {
  std::string text = fmt::format(
      "ply\nformat ascii 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty "
      "float z\nend_header\n",
      cloud.size());
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const glm::dvec3 p = cloud.world(i);
    text += fmt::format("{} {} {}\n", p.x, p.y, p.z);
  }
  FetchedFrame frame;
  frame.file = Bytes(text.begin(), text.end());
  return frame;
}

double worst_normal_error(const PointCloud& cloud) {
  double worst = 1.0;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const auto outward = glm::normalize(cloud.world(i) - glm::dvec3(10.0, 0.0, 0.0));
    worst = std::min(worst, glm::dot(outward, glm::dvec3(cloud.normals[i])));
  }
  return worst;
}

/// The leaves of a frame's tree, with their normals.
PointCloud leaves_of(const SceneFrame& scene) {
  PointCloud leaves = leaf_centers(scene.svo);
  for (std::size_t i = scene.svo.internal_count(); i < scene.attributes.normals.size(); ++i) {
    leaves.normals.push_back(glm::vec3(scene.attributes.normals[i]) / 32767.0f);
  }
  return leaves;
}

TEST(PrepareFrame, keeps_the_tree_of_an_octree_frame_and_covers_it_with_surfels) {
  const PointCloud cloud = sphere(20'000, true, true);
  const Manifest manifest = manifest_of(cloud);
  const auto scene =
      prepare_frame(manifest, 1, fetched(cloud, octree(0.05)), {DrawMode::surfel, 0.05});
  ASSERT_TRUE(scene) << scene.error().message;
  EXPECT_EQ(scene->index, 1u);
  EXPECT_EQ(scene->time_us, 40'000u);
  EXPECT_EQ(scene->points, 20'000u);
  EXPECT_EQ(scene->level, kWholeFrame);
  EXPECT_EQ(scene->svo.cube, kCube);
  EXPECT_TRUE(scene->cloud.empty()) << "the tree gives the positions";
  const std::size_t nodes = scene->svo.node_count(), inner = scene->svo.internal_count();
  ASSERT_EQ(scene->radii.size(), nodes);
  const double least = std::sqrt(3.0) / 2.0 * 3.0 / (1 << scene->svo.depth);
  for (std::size_t i = inner; i < nodes; ++i) {
    ASSERT_GE(scene->radii[i], 0.999 * least);
    ASSERT_LE(scene->radii[i], 0.1);
  }
  EXPECT_EQ(scene->attributes.colors.size(), nodes);
  ASSERT_EQ(scene->attributes.normals.size(), nodes);
  EXPECT_GT(worst_normal_error(leaves_of(*scene)), 0.95);
}

TEST(PrepareFrame, leaves_the_surfels_of_large_frames_in_their_cells) {
  const PointCloud cloud = sphere(400'000, true, true);
  EncodeOptions fine = octree(0.05);
  std::get<OctreeOptions>(fine.codec).depth = DepthRule::fixed(10);
  const auto scene =
      prepare_frame(manifest_of(cloud), 0, fetched(cloud, fine), {.mode = DrawMode::surfel});
  ASSERT_TRUE(scene);
  ASSERT_GT(scene->svo.leaf_count(), 300'000u);
  EXPECT_TRUE(scene->heights.empty());
  EXPECT_EQ(surfels_of(*scene).positions, leaf_centers(scene->svo).positions);
}

TEST(PrepareFrame, puts_surfels_onto_the_surface_and_leaves_points_in_their_cells) {
  const PointCloud cloud = sphere(60'000, true, true);
  EncodeOptions coarse = octree(0.05);
  std::get<OctreeOptions>(coarse.codec).depth = DepthRule::fixed(6);
  const FetchedFrame frame = fetched(cloud, coarse);
  const auto scene = prepare_frame(manifest_of(cloud), 0, frame, {.mode = DrawMode::surfel});
  ASSERT_TRUE(scene);
  ASSERT_EQ(scene->heights.size(), scene->svo.leaf_count());
  const auto off = [](const PointCloud& surfels) {
    double squares = 0.0;
    for (std::size_t i = 0; i < surfels.size(); ++i) {
      const double above = glm::distance(surfels.world(i), glm::dvec3(10.0, 0.0, 0.0)) - 1.0;
      squares += above * above;
    }
    return std::sqrt(squares / static_cast<double>(surfels.size()));
  };
  EXPECT_LT(off(surfels_of(*scene)), 0.4 * off(leaf_centers(scene->svo)));

  const auto points = prepare_frame(manifest_of(cloud), 0, frame, {.mode = DrawMode::point});
  ASSERT_TRUE(points);
  EXPECT_TRUE(points->heights.empty());
  EXPECT_EQ(surfels_of(*points).positions, leaf_centers(points->svo).positions);
}

TEST(PrepareFrame, gives_the_same_for_a_frame_in_slabs) {
  const PointCloud cloud = sphere(20'000, false, true);
  OctreeOptions options{Entropy::context, DepthRule::fixed(10)};
  const FetchedFrame whole = fetched(cloud, {options});
  options.slabs = 3;
  const FetchedFrame parted = fetched(cloud, {options});
  ASSERT_NE(parted.layers[1].bytes, whole.layers[1].bytes);
  const auto expected = prepare_frame(manifest_of(cloud), 0, whole, {DrawMode::point, 0.05});
  const auto scene = prepare_frame(manifest_of(cloud), 0, parted, {DrawMode::point, 0.05});
  ASSERT_TRUE(scene && expected);
  EXPECT_EQ(scene->svo.masks, expected->svo.masks);
  EXPECT_EQ(scene->attributes.colors, expected->attributes.colors);
}

TEST(PrepareFrame, has_normals_in_every_mode_that_shows_them) {
  for (const bool with_normals : {true, false}) {
    const PointCloud cloud = sphere(5'000, with_normals, true);
    const Manifest manifest = manifest_of(cloud);
    for (const FetchedFrame& frame :
         {fetched(cloud, octree(0.05)), fetched(cloud, {DracoOptions{}})}) {
      for (const DrawMode mode : {DrawMode::voxel, DrawMode::point}) {
        const auto without = prepare_frame(manifest, 0, frame, {mode, 0.05});
        ASSERT_TRUE(without);
        EXPECT_TRUE(without->attributes.normals.empty() && !without->cloud.has_normals());
        const auto scene =
            prepare_frame(manifest, 0, frame, {.mode = mode, .delta = 0.05, .show_normals = true});
        ASSERT_TRUE(scene);
        if (scene->cloud.empty())
          EXPECT_EQ(scene->attributes.normals.size(), scene->svo.node_count());
        else
          EXPECT_TRUE(scene->cloud.has_normals());
        EXPECT_EQ(scene->normals_estimated, !with_normals);
        Manifest estimated = manifest;
        estimated.normals_estimated = true;
        const auto either_side =
            prepare_frame(estimated, 0, frame, {.mode = mode, .delta = 0.05, .show_normals = true});
        ASSERT_TRUE(either_side);
        EXPECT_TRUE(either_side->normals_estimated);
      }
    }
  }
}

TEST(PrepareFrame, truncates_the_tree_of_voxels_at_the_coarsest_level_within_delta) {
  const PointCloud cloud = sphere(20'000, false, true);
  const Manifest manifest = manifest_of(cloud);
  const FetchedFrame fine = fetched(cloud, octree(0.001));
  const auto full = prepare_frame(manifest, 0, fine, {DrawMode::voxel, 0.001});
  const auto cut = prepare_frame(manifest, 0, fine, {DrawMode::voxel, 0.5});
  ASSERT_TRUE(full && cut);
  EXPECT_LT(cut->svo.depth, full->svo.depth);
  EXPECT_GE(cut->svo.leaf_count(), 10'000u);
  EXPECT_LT(cut->svo.node_count(cut->svo.depth - 1), 10'000u);
  EXPECT_EQ(cut->level, kWholeFrame);
  ASSERT_EQ(cut->attributes.colors.size(), cut->svo.node_count());
  for (std::size_t i = 0, node = 0; i < cut->attributes.colors.size(); ++i) {
    if (!cut->filled.empty() && cut->filled[i]) continue;
    ASSERT_EQ(cut->attributes.colors[i], full->attributes.colors[node++]);
  }
  const auto points = prepare_frame(manifest, 0, fine, {DrawMode::point, 0.5});
  EXPECT_EQ(points->svo.depth, full->svo.depth) << "delta applies to voxels only";
}

TEST(PrepareFrame, fills_gaps_between_voxels_that_do_not_touch) {
  const PointCloud cloud = sphere(5'000, true, true);
  const Manifest manifest = manifest_of(cloud);
  for (const FetchedFrame& frame : {fetched(cloud, octree(0.05)), ply(cloud)}) {
    const auto surfels = prepare_frame(manifest, 0, frame, {DrawMode::surfel});
    ASSERT_TRUE(surfels);
    EXPECT_TRUE(surfels->filled.empty());
    // With nearly one voxel per point, the gaps between them cannot be closed.
    const auto fine = prepare_frame(manifest, 0, frame, {DrawMode::voxel, 0.05});
    ASSERT_TRUE(fine);
    EXPECT_TRUE(fine->filled.empty());
    const auto voxels = prepare_frame(manifest, 0, frame, {DrawMode::voxel, 0.72});
    ASSERT_TRUE(voxels);
    ASSERT_EQ(voxels->filled.size(), voxels->svo.node_count());
    const double growth =
        voxels->svo.leaf_count() / double(voxels->svo.node_count(voxels->svo.depth - 1));
    EXPECT_GT(growth, 3.3) << "the growth is that of a closed surface";
  }
}

TEST(PrepareFrame, reports_the_finest_level_that_it_has) {
  const PointCloud cloud = sphere(20'000, false, true);
  EncodeOptions options{OctreeOptions{Entropy::context, DepthRule::fixed(10)}};
  FetchedFrame frame;
  const Manifest manifest = manifest_of(cloud);
  for (const DrawMode mode : {DrawMode::surfel, DrawMode::voxel, DrawMode::point}) {
    frame = fetched(cloud, options);
    EXPECT_EQ(prepare_frame(manifest, 0, frame, {mode, 0.0})->level, kWholeFrame);
    frame.layers.resize(2);
    const auto scene = prepare_frame(manifest, 0, frame, {mode, 0.0});
    EXPECT_EQ(scene->level, 9);
    EXPECT_EQ(scene->layers, 2u);
    frame.layers.resize(1);
    EXPECT_EQ(prepare_frame(manifest, 0, frame, {mode, 0.0})->level, 7);
  }
  // Layers that were fetched but are too fine to be seen are not decoded.
  frame = fetched(cloud, options);
  for (const int level : {5, 7, 8, 10, 12}) {
    const auto scene = prepare_frame(manifest, 0, frame, {DrawMode::point, 0.0, level});
    EXPECT_EQ(scene->svo.depth, std::min(level, 10));
    EXPECT_EQ(scene->level, level < 10 ? level : kWholeFrame);
    EXPECT_EQ(scene->attributes.colors.size(), scene->svo.node_count());
  }
  frame.layers.resize(1);
  // Voxels are complete if the fetched layers satisfy delta.
  const auto scene = prepare_frame(manifest, 0, frame, {DrawMode::voxel, 0.7});
  EXPECT_EQ(scene->level, kWholeFrame);
  EXPECT_LE(scene->svo.depth, 7);
}

TEST(PrepareFrame, has_normals_of_the_finest_leaves_only_for_views_that_are_closer) {
  const PointCloud cloud = sphere(20'000, true, true);
  const Manifest manifest = manifest_of(cloud);
  const FetchedFrame frame = fetched(cloud, {OctreeOptions{Entropy::context, DepthRule::fixed(8)}});
  const auto differ_from_parents = [](const SceneFrame& scene) {
    const std::vector<glm::i16vec3>& normals = scene.attributes.normals;
    int count = 0;
    for (std::uint32_t node = scene.svo.level_begin[7]; node < scene.svo.level_begin[8]; ++node)
      count += normals[scene.svo.first_child[node]] != normals[node] ? 1 : 0;
    return count;
  };
  PrepareOptions options;
  options.level = 9;
  const auto closer = prepare_frame(manifest, 0, frame, options);
  EXPECT_EQ(closer->level, kWholeFrame);
  EXPECT_GT(differ_from_parents(*closer), 0);
  options.level = 8;
  const auto away = prepare_frame(manifest, 0, frame, options);
  EXPECT_EQ(away->level, 8) << "a closer view needs the frame to be prepared again";
  EXPECT_EQ(differ_from_parents(*away), 0);
  EXPECT_EQ(away->attributes.colors, closer->attributes.colors);
  EXPECT_FALSE(away->boxes.rough);
  options.show_normals = true;
  EXPECT_GT(differ_from_parents(*prepare_frame(manifest, 0, frame, options)), 0);
}

TEST(PrepareFrame, computes_the_means_of_lossless_colours) {
  const PointCloud cloud = sphere(5'000, true, true);
  OctreeOptions options{Entropy::context, DepthRule::fixed(8), kLosslessColorQuality,
                        kBestNormalQuality};
  const auto scene =
      prepare_frame(manifest_of(cloud), 0, fetched(cloud, {options}), {DrawMode::surfel, 0.05});
  ASSERT_TRUE(scene) << scene.error().message;
  ASSERT_EQ(scene->attributes.colors.size(), scene->svo.node_count());
  EXPECT_EQ(scene->attributes.normals.size(), scene->svo.node_count());
  EXPECT_NEAR(scene->attributes.colors[0].x, 32768, 3000) << "half the sphere is red";
}

TEST(PrepareFrame, builds_the_tree_of_a_draco_frame_in_the_cube_of_its_segment) {
  const PointCloud cloud = sphere(5'000, false, true);
  const auto scene = prepare_frame(manifest_of(cloud), 0, fetched(cloud, {DracoOptions{}}),
                                   {DrawMode::voxel, 0.05});
  ASSERT_TRUE(scene) << scene.error().message;
  EXPECT_EQ(scene->svo.cube, kCube);
  EXPECT_GE(scene->svo.leaf_count(), 4'750u);
  EXPECT_EQ(scene->attributes.colors.size(), scene->svo.node_count());
  EXPECT_TRUE(scene->attributes.normals.empty());
  EXPECT_TRUE(scene->cloud.empty());
}

TEST(PrepareFrame, builds_a_tree_for_points_only_if_the_view_is_coarser_than_they_are) {
  const PointCloud cloud = sphere(20'000, true, true);
  const Manifest manifest = manifest_of(cloud);
  for (const EncodeOptions& options : {EncodeOptions{DracoOptions{}}}) {
    const FetchedFrame frame = fetched(cloud, options);
    for (const DrawMode mode : {DrawMode::point, DrawMode::surfel}) {
      for (const int level : {kWholeFrame, 9}) {
        const auto all = prepare_frame(manifest, 0, frame, {mode, 0.7, level});
        ASSERT_TRUE(all) << all.error().message;
        EXPECT_EQ(all->cloud.size(), 20'000u);
        EXPECT_EQ(all->svo.node_count(), 0u);
        EXPECT_TRUE(all->attributes.colors.empty());
        EXPECT_EQ(all->level, kWholeFrame);
        EXPECT_EQ(all->cloud.has_radii(), mode == DrawMode::surfel);
      }
      const auto coarse = prepare_frame(manifest, 0, frame, {mode, 0.7, 5});
      ASSERT_TRUE(coarse) << coarse.error().message;
      EXPECT_TRUE(coarse->cloud.empty());
      EXPECT_EQ(coarse->svo.depth, 5);
      EXPECT_EQ(coarse->svo.cube, kCube);
      EXPECT_LT(coarse->svo.leaf_count(), 5'000u);
      EXPECT_EQ(coarse->level, 5);
      EXPECT_EQ(coarse->points, 20'000u);
      EXPECT_EQ(coarse->attributes.colors.size(), coarse->svo.node_count());
      EXPECT_EQ(coarse->radii.size(), mode == DrawMode::surfel ? coarse->svo.node_count() : 0u);
    }
    const auto voxels = prepare_frame(manifest, 0, frame, {DrawMode::voxel, 0.05, 5});
    EXPECT_EQ(voxels->svo.depth, 5);
    EXPECT_EQ(voxels->level, 5);
  }
}

TEST(PrepareFrame, estimates_attributes_that_a_file_lacks_and_the_mode_needs) {
  const PointCloud cloud = sphere(5'000, false, false);
  const Manifest manifest = manifest_of(cloud);
  const FetchedFrame file = ply(cloud);
  const auto surfels = prepare_frame(manifest, 0, file, {DrawMode::surfel, 0.05});
  ASSERT_TRUE(surfels) << surfels.error().message;
  EXPECT_GT(worst_normal_error(surfels->cloud), 0.9);
  EXPECT_TRUE(surfels->cloud.has_radii());
  EXPECT_FALSE(surfels->cloud.has_colors());
  const auto voxels = prepare_frame(manifest, 0, file, {DrawMode::voxel, 0.05});
  EXPECT_EQ(voxels->attributes.normals.size(), voxels->svo.node_count());
  EXPECT_NEAR(voxels->svo.cube.edge, 2.0, 0.05) << "a file has a cube of its own";
  const auto points = prepare_frame(manifest, 0, file, {DrawMode::point, 0.05});
  EXPECT_TRUE(points->cloud.has_normals()) << "the light needs them";
  EXPECT_FALSE(points->cloud.has_radii());
}

TEST(PrepareFrame, fails_soon_if_it_is_asked_to_stop) {
  const PointCloud cloud = sphere(1'000, false, true);
  std::stop_source stop;
  const auto prepared = [&] {
    return pointreel::prepare_frame(fetched(cloud, octree(0.05)), frame_info(manifest_of(cloud), 0),
                                    {}, [&] { return stop.stop_requested(); });
  };
  EXPECT_TRUE(prepared());
  stop.request_stop();
  ASSERT_FALSE(prepared());
  EXPECT_EQ(prepared().error().code, ErrorCode::cancelled);
}

TEST(PrepareFrame, estimates_the_normals_that_an_octree_frame_lacks) {
  const PointCloud cloud = sphere(5'000, false, true);
  const auto scene = prepare_frame(manifest_of(cloud), 0, fetched(cloud, octree(0.05)), {});
  ASSERT_TRUE(scene) << scene.error().message;
  EXPECT_TRUE(scene->normals_estimated);
  EXPECT_EQ(scene->attributes.normals.size(), scene->svo.node_count());
  EXPECT_GT(worst_normal_error(leaves_of(*scene)), 0.9);
}

TEST(PrepareFrame, neither_estimates_nor_keeps_normals_if_colours_are_drawn) {
  for (const bool normals : {false, true}) {
    const PointCloud cloud = sphere(1'000, normals, true);
    const auto scene =
        prepare_frame(manifest_of(cloud), 0, fetched(cloud, octree(0.05)), {DrawMode::point, 0.05});
    ASSERT_TRUE(scene);
    EXPECT_FALSE(scene->attributes.colors.empty());
    EXPECT_TRUE(scene->attributes.normals.empty());
    const auto draco = prepare_frame(manifest_of(cloud), 0, fetched(cloud, {DracoOptions{}}),
                                     {DrawMode::point, 0.05});
    ASSERT_TRUE(draco);
    EXPECT_TRUE(draco->cloud.has_colors());
    EXPECT_FALSE(draco->cloud.has_normals());
  }
}

TEST(PrepareFrame, turns_a_frame_without_points_into_an_empty_scene) {
  const PointCloud empty;
  for (const DrawMode mode : {DrawMode::surfel, DrawMode::voxel, DrawMode::point}) {
    for (const FetchedFrame& frame :
         {fetched(empty, octree(0.05)), fetched(empty, {DracoOptions{}}), ply(empty)}) {
      const auto scene = prepare_frame(manifest_of(empty), 0, frame, {mode, 0.05});
      ASSERT_TRUE(scene) << scene.error().message;
      EXPECT_TRUE(scene->cloud.empty());
      EXPECT_EQ(scene->svo.node_count(), 0u);
    }
  }
}

/// The voxels of a grid of whole numbers that a sphere passes through.
PointCloud voxelised_sphere(int radius) {
  PointCloud cloud;
  for (int x = -radius; x <= radius; ++x)
    for (int y = -radius; y <= radius; ++y)
      for (int z = -radius; z <= radius; ++z)
        if (std::abs(std::sqrt(x * x + y * y + z * z) - radius) < 0.7)
          cloud.positions.emplace_back(x, y, z);
  return cloud;
}

TEST(PrepareFrame, draws_a_large_cloud_of_voxels_as_a_tree_that_loses_nothing) {
  const PointCloud cloud = voxelised_sphere(100);
  ASSERT_GT(cloud.size(), 150'000u);
  const Manifest manifest = manifest_of(cloud);
  const FetchedFrame file = ply(cloud);
  for (const DrawMode mode : {DrawMode::surfel, DrawMode::point}) {
    const auto whole = prepare_frame(manifest, 0, file, {mode});
    ASSERT_TRUE(whole);
    EXPECT_EQ(whole->level, kWholeFrame);
    EXPECT_TRUE(whole->cloud.empty());
    ASSERT_EQ(whole->svo.leaf_count(), cloud.size());
    const PointCloud leaves = leaf_centers(whole->svo);
    for (std::size_t i = 0; i < leaves.size(); ++i)
      ASSERT_LT(glm::distance(leaves.world(i), glm::round(leaves.world(i))), 1e-3);
    EXPECT_EQ(whole->radii.size(), mode == DrawMode::surfel ? whole->svo.node_count() : 0u);

    PrepareOptions options{mode};
    options.level = 6;
    const auto coarse = prepare_frame(manifest, 0, file, options);
    ASSERT_TRUE(coarse);
    EXPECT_EQ(coarse->level, 6) << "the level that was asked for";
    EXPECT_EQ(coarse->svo.depth, 7) << "its cube is larger than that of the bounds";
    EXPECT_LT(coarse->svo.leaf_count(), cloud.size() / 3);
  }
}

TEST(PrepareFrame, reports_the_problem_with_damaged_bytes) {
  const PointCloud cloud = sphere(1'000, false, true);
  FetchedFrame frame = fetched(cloud, octree(0.05));
  Bytes damaged(frame.layers[0].bytes.begin(), frame.layers[0].bytes.end());
  damaged[frame.layers[0].sizes.geometry / 2] ^= 1;
  frame.layers[0].bytes = std::move(damaged);
  EXPECT_FALSE(prepare_frame(manifest_of(cloud), 0, frame, {DrawMode::surfel, 0.05}));
  FetchedFrame nothing;
  nothing.file_name = "folder/f7.ply";
  const auto scene = prepare_frame(manifest_of(cloud), 0, nothing, {DrawMode::surfel, 0.05});
  ASSERT_FALSE(scene);
  EXPECT_THAT(scene.error().message, testing::StartsWith("folder/f7.ply: "));
}

TEST(PrepareFrame, decodes_no_frame_that_takes_more_memory_than_allowed) {
  const PointCloud cloud = sphere(1'000, true, true);
  for (const EncodeOptions& codec : {octree(0.05), EncodeOptions{DracoOptions{}}}) {
    const FetchedFrame frame = fetched(cloud, codec);
    PrepareOptions options;
    EXPECT_TRUE(prepare_frame(manifest_of(cloud), 0, frame, options));
    options.max_memory = 1024;
    const auto refused = prepare_frame(manifest_of(cloud), 0, frame, options);
    ASSERT_FALSE(refused);
    EXPECT_THAT(refused.error().message, testing::HasSubstr("raise --frame-memory"));
  }
}

TEST(PrepareFrame, has_a_box_without_points_far_away) {
  PointCloud cloud = sphere(20'000, false, true);
  cloud.positions[100] = {1.4f, 1.4f, 1.4f};
  const Manifest manifest = manifest_of(cloud);
  for (const DrawMode mode : {DrawMode::surfel, DrawMode::voxel})
    for (const FetchedFrame& frame : {fetched(cloud, EncodeOptions{OctreeOptions{}}), ply(cloud)}) {
      const Box box = prepare_frame(manifest, 0, frame, {mode})->boxes.main;
      for (int axis = 0; axis < 3; ++axis) {
        EXPECT_NEAR(box.extent()[axis], 2.15, 0.2) << "2.4 with that point";
        EXPECT_NEAR(box.center()[axis], axis == 0 ? 10.0 : 0.0, 0.05);
      }
    }
}

TEST(PrepareFrame, has_no_box_for_points_that_coincide) {
  PointCloud same;
  same.origin = kCube.origin;
  same.positions.assign(20, glm::vec3(0.9f, 1.8f, 0.3f));
  const Manifest manifest = manifest_of(same);
  for (const FetchedFrame& frame : {fetched(same, EncodeOptions{OctreeOptions{}}), ply(same)})
    for (const DrawMode mode : {DrawMode::surfel, DrawMode::voxel, DrawMode::point})
      EXPECT_TRUE(prepare_frame(manifest, 0, frame, {mode})->boxes.main.empty());
}

TEST(PrepareFrame, draws_a_single_point_at_its_place_and_size_within_a_large_cube) {
  PointCloud one;
  one.origin = kCube.origin;
  one.positions = {glm::vec3(0.9f, 1.8f, 0.3f)};
  const Manifest manifest = manifest_of(one);
  const FetchedFrame frame = fetched(one, EncodeOptions{OctreeOptions{}});
  const SceneFrame surfel = prepare_frame(manifest, 0, frame, {DrawMode::surfel}).value();
  EXPECT_TRUE(surfel.boxes.main.empty()) << "which tells no size, so the view shows all frames";
  ASSERT_EQ(surfel.svo.leaf_count(), 1u);
  EXPECT_LT(glm::distance(leaf_centers(surfel.svo).world(0), one.world(0)), 1e-3);
  EXPECT_GT(surfel.radii.back(), 0.03f);
  EXPECT_LT(surfel.radii.back(), 0.15f);
  const SceneFrame voxel = prepare_frame(manifest, 0, frame, {DrawMode::voxel}).value();
  EXPECT_EQ(voxel.svo.depth, 3);
}

/// The sphere with its height as a field, and the side on which a point lies as a label.
PointCloud with_scalars(std::size_t points) {
  PointCloud cloud = sphere(points, true, true);
  cloud.scalars = {{"height", {}}, {"side", {}}};
  for (const glm::vec3& p : cloud.positions) {
    cloud.scalars[0].values.push_back(p.y);
    cloud.scalars[1].values.push_back(p.x > 0 ? 4.0f : 1.0f);
  }
  return cloud;
}

Manifest with_ranges(const PointCloud& cloud) {
  Manifest manifest = manifest_of(cloud);
  manifest.scalars = {{"height", -2.0, 2.0, false}, {"side", 1, 4, true}};
  return manifest;
}

constexpr glm::u16vec3 kGrey = glm::u16vec3(kUnknownColor) * std::uint16_t{257};

TEST(PrepareFrame, colours_a_tree_by_a_scalar_field_in_the_range_of_the_reel) {
  const PointCloud cloud = with_scalars(20'000);
  PrepareOptions options;
  options.scalar.field = "height";
  const auto scene = prepare_frame(with_ranges(cloud), 0, fetched(cloud, octree(0.05)), options);
  ASSERT_TRUE(scene) << scene.error().message;
  ASSERT_TRUE(scene->scalar);
  EXPECT_EQ(scene->scalar->range, (ScalarRange{"height", -2.0, 2.0, false}));
  ASSERT_EQ(scene->attributes.colors.size(), scene->svo.node_count());
  const PointCloud leaves = leaf_centers(scene->svo);
  const double cell = scene->svo.cell_size(scene->svo.depth), steps = 2.0 / 255;
  for (std::size_t i = 0; i < leaves.size(); ++i) {
    const glm::vec3 color(scene->attributes.colors[scene->svo.internal_count() + i]);
    const double share = (leaves.world(i).y + 2.0) / 4.0, near = (cell + steps) / 4.0;
    const glm::vec3 expected = 257.0f * glm::vec3(ramp_color(share));
    const float slack = 257.0f * (2.0f + glm::length(glm::vec3(ramp_color(share + near)) -
                                                     glm::vec3(ramp_color(share - near))));
    ASSERT_LT(glm::length(color - expected), slack) << share;
  }
  EXPECT_EQ(scene->level, kWholeFrame);
}

TEST(PrepareFrame, never_mixes_the_colours_of_labels) {
  const PointCloud cloud = with_scalars(5'000);
  const auto right = glm::u16vec3(label_color(4)) * std::uint16_t{257};
  const auto left = glm::u16vec3(label_color(1)) * std::uint16_t{257};
  for (const DrawMode mode : {DrawMode::surfel, DrawMode::point}) {
    PrepareOptions options;
    options.mode = mode;
    options.scalar.field = "side";
    const auto scene = prepare_frame(with_ranges(cloud), 0, fetched(cloud, octree(0.05)), options);
    ASSERT_TRUE(scene) << scene.error().message;
    EXPECT_THAT(scene->scalar->labels, testing::ElementsAre(1, 4));
    for (const glm::u16vec3& color : scene->attributes.colors)
      ASSERT_TRUE(color == left || color == right);
  }
}

TEST(PrepareFrame, is_grey_and_wants_more_until_the_layer_of_scalar_fields_is_there) {
  const PointCloud cloud = with_scalars(20'000);
  FetchedFrame frame = fetched(cloud, octree(0.05));
  PrepareOptions options;
  options.scalar.field = "height";
  frame.layers.pop_back();
  for (const DrawMode mode : {DrawMode::surfel, DrawMode::voxel, DrawMode::point}) {
    options.mode = mode;
    const auto scene = prepare_frame(with_ranges(cloud), 0, frame, options);
    ASSERT_TRUE(scene) << scene.error().message;
    EXPECT_FALSE(scene->scalar);
    EXPECT_EQ(scene->level, 0);
    EXPECT_THAT(scene->attributes.colors, testing::Each(kGrey));
    ASSERT_EQ(scene->attributes.colors.size(), scene->svo.node_count());
  }
}

TEST(PrepareFrame, colours_clouds_of_files_by_their_scalar_fields) {
  const PointCloud cloud = with_scalars(500);
  FetchedFrame frame;
  frame.file = ply_bytes(cloud);
  PrepareOptions options;
  options.scalar = {"height", glm::dvec2(-1.0, 0.0)};
  const auto scene = prepare_frame(manifest_of(cloud), 0, frame, options);
  ASSERT_TRUE(scene) << scene.error().message;
  EXPECT_EQ(scene->scalar->range, (ScalarRange{"height", -1.0, 0.0, false}));
  ASSERT_EQ(scene->cloud.colors.size(), cloud.size());
  for (std::size_t i = 0; i < cloud.size(); ++i)
    EXPECT_EQ(scene->cloud.colors[i],
              glm::u16vec3(ramp_color(cloud.positions[i].y + 1.0)) * std::uint16_t{257});
  EXPECT_FALSE(scene->cloud.has_scalars());
  options.scalar.field = "depth";
  const auto without = prepare_frame(manifest_of(cloud), 0, frame, options);
  EXPECT_THAT(without->cloud.colors, testing::Each(kGrey));
}

}  // namespace
}  // namespace pointreel::prepare_test
