// Packing with --clean.

#include <cmath>
#include <fstream>
#include <random>

#include <gtest/gtest.h>

#include "client/prepare/prepare.h"
#include "client/source/open_source.h"
#include "codec/package/encoding_options.h"
#include "datasets_synthetic/motion.h"
#include "datasets_synthetic/sequences.h"
#include "server/inspect/inspect.h"
#include "server/pack/packer.h"
#include "tests/pack_folder.h"

namespace pointreel::pack_clean_test {
namespace {

using PackClean = PackFolder;

/// A scan with noise, and a few specks around it.
PointCloud noisy(std::uint32_t seed) {
  PointCloud cloud = ellipsoid(8000);
  std::mt19937 random(seed);
  std::normal_distribution<float> normal;
  const auto vector = [&] {
    // Each by itself, since compilers choose in which order they compute arguments.
    const float z = normal(random), y = normal(random), x = normal(random);
    return glm::vec3(x, y, z);
  };
  for (glm::vec3& p : cloud.positions) p += 0.01f * vector();
  for (glm::vec3& n : cloud.normals) n = glm::normalize(n + 0.3f * vector());
  for (std::size_t i = 0; i < 10; ++i) cloud.positions[i] *= 2.0f + 0.2f * static_cast<float>(i);
  return cloud;
}

TEST_F(PackClean, takes_noise_out_and_says_what_it_did) {
  for (int i = 0; i < 3; ++i) write(i, noisy(static_cast<std::uint32_t>(i)));
  const PackSummary source = packed();
  EXPECT_EQ(source.cleaning.frames, 0u);
  options_.clean = CleanOptions{};
  const PackSummary cleaned = packed();
  EXPECT_EQ(cleaned.cleaning.frames, 3u);
  EXPECT_NEAR(cleaned.cleaning.noise, 0.01, 0.004);
  EXPECT_GE(cleaned.cleaning.removed, 3u * 9);
  EXPECT_EQ(cleaned.points, source.points) << "are those of the source";
  EXPECT_LT(cleaned.parts->normals, source.parts->normals * 3 / 4);
  EXPECT_TRUE(verify(options_.output)->faults.empty());
  EXPECT_EQ(read_manifest(options_.output)->cleaning, cleaned.cleaning);
}

TEST_F(PackClean, frames_around_each_one_help_whatever_segments_they_are_in) {
  for (int i = 0; i < 5; ++i) write(i, noisy(static_cast<std::uint32_t>(i)));
  options_.clean = CleanOptions{};
  options_.cube_per_frame = true;
  const PackSummary alone = packed();
  options_.clean_frames = 2;
  const PackSummary together = packed();
  EXPECT_EQ(together.cleaning.frames, 5u);
  EXPECT_LT(together.cleaning.radius, 0.95 * alone.cleaning.radius);
  EXPECT_EQ(together.cleaning.removed, alone.cleaning.removed);
  EXPECT_LT(together.bytes, alone.bytes);
  options_.segment_frames = 2;
  EXPECT_EQ(packed().segment_bytes, together.segment_bytes);
}

TEST_F(PackClean, a_frame_that_cannot_be_read_is_missing_to_those_around_it_only) {
  for (int i = 0; i < 5; ++i) write(i, noisy(static_cast<std::uint32_t>(i)));
  std::ofstream(in() / "2.ply") << "ply\n";
  options_.clean = CleanOptions{};
  options_.clean_frames = 2;
  const auto failed = pack(options_);
  ASSERT_FALSE(failed);
  EXPECT_NE(failed.error().message.find("2.ply"), std::string::npos) << failed.error().message;
  options_.best_effort = true;
  const PackSummary summary = packed();
  EXPECT_EQ(summary.unreadable_frames, 1u);
  EXPECT_EQ(summary.cleaning.frames, 5u);
}

TEST_F(PackClean, reads_large_segments_twice_with_the_same_result) {
  write(0, noisy(1));
  options_.clean = CleanOptions{0.1};
  const PackSummary once = packed();
  options_.cube_per_frame = true;  // the frame is read only once
  EXPECT_EQ(packed().cleaning.removed, once.cleaning.removed);
}

TEST_F(PackClean, has_cells_of_half_the_spacing_unless_a_depth_is_given) {
  OctreeOptions octree;
  octree.depth = DepthRule::by_delta(0.0);  // as deep as it takes to tell all points apart
  octree.normals_follow_noise = false;      // or else the noise that is cleaned takes few bytes
  options_.encode.codec = octree;
  for (int i = 0; i < 3; ++i) write(i, noisy(static_cast<std::uint32_t>(i)));
  const PackSummary source = packed();
  options_.clean = CleanOptions{};
  for (const bool cube_per_frame : {false, true}) {
    options_.cube_per_frame = cube_per_frame;
    const PackSummary cleaned = packed();
    const double cell = 0.5 * cleaned.cleaning.spacing;
    EXPECT_LT(cleaned.max_error, cell) << "half the diagonal of a cell";
    EXPECT_GT(cleaned.max_error, 0.6 * cell);
    EXPECT_LT(cleaned.bytes, source.bytes / 2);
  }
  octree.depth = DepthRule::fixed(14);
  options_.encode.codec = octree;
  EXPECT_EQ(packed().depth_max, 14u);
}

TEST_F(PackClean, leaves_frames_alone_that_are_smooth_or_have_voxels) {
  write(0, ellipsoid(8000));
  options_.clean = CleanOptions{};
  const PackSummary smooth = packed();
  EXPECT_EQ(smooth.cleaning.frames, 0u);
  EXPECT_EQ(why_not_cleaned(*options_.clean, smooth.not_cleaned), "the frames are smooth");
  write(0, noisy(1));
  EXPECT_EQ(packed().cleaning.frames, 1u);
  EXPECT_TRUE(packed().not_cleaned.empty());
  options_.voxel = 0.01;
  EXPECT_EQ(packed().cleaning.frames, 0u);
  options_.clean = CleanOptions{0.1};
  EXPECT_EQ(packed().cleaning.frames, 1u) << "was asked for";
}

TEST_F(PackClean, samples_the_surface_anew_at_a_spacing) {
  for (int i = 0; i < 3; ++i) write(i, noisy(static_cast<std::uint32_t>(i)));
  options_.clean = CleanOptions{};
  const PackSummary cleaned = packed();
  options_.voxel = 0.1;
  options_.resample = true;
  const PackSummary sampled = packed();
  EXPECT_EQ(sampled.cleaning.removed, cleaned.cleaning.removed);
  EXPECT_LT(sampled.max_error, 0.1);
  EXPECT_LT(sampled.bytes, cleaned.bytes / 2);
  EXPECT_NEAR(read_manifest(options_.output)->segments[0].cube.edge,
              0.1 * std::exp2(sampled.depth_max), 1e-9);
}

TEST_F(PackClean, sends_normals_only_if_the_source_has_them) {
  PointCloud cloud = noisy(1);
  write(0, cloud);
  options_.clean = CleanOptions{};
  EXPECT_GT(packed().parts->normals, 0u);
  cloud.normals.clear();
  write(0, cloud);
  const PackSummary without = packed();
  EXPECT_EQ(without.cleaning.frames, 1u);
  EXPECT_EQ(without.parts->normals, 0u);
}

TEST_F(PackClean, the_voxels_of_a_cleaned_scan_close) {
  options_.clean = CleanOptions{};
  for (const char* name : {"baseball", "basketball", "kick", "soccer-juggle", "soccer-shoot"}) {
    SequenceOptions sampling;
    sampling.sampler = Sampler::scan;
    write(0, sequence_frame(*find_motion(name), sampling, 0).value());
    ASSERT_EQ(packed().cleaning.frames, 1u) << name;
    const auto source = open_source(options_.output.string());
    ASSERT_TRUE(source) << source.error().message;
    const auto frame =
        prepare_frame((*source)->fetch({0}).value(), frame_info((*source)->manifest(), 0),
                      {.mode = DrawMode::voxel});
    ASSERT_TRUE(frame) << frame.error().message;
    const Svo& svo = frame->svo;
    EXPECT_GT(svo.leaf_count(), 3.3 * svo.node_count(svo.depth - 1)) << name;
    EXPECT_GT(svo.cube.edge / std::exp2(svo.depth), 0.005) << name << ": voxels in metres";
  }
}

}  // namespace
}  // namespace pointreel::pack_clean_test
