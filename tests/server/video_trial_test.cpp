#include "server/pack/video_trial.h"

#include <filesystem>
#include <optional>
#include <random>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "server/pack/in_arena.h"
#include "server/parts/plan.h"
#include "tests/pack_folder.h"

namespace pointreel::video_trial_test {
namespace {

class VideoTrialTest : public PackFolder {
 protected:
  VideoTrialTest() {
    options_.encode.codec = OctreeOptions{};
    options_.video_if_it_pays = VideoPackOptions{};
  }

  /// So many frames that show the same.
  void write_frames(const PointCloud& cloud, int frames = 16) {
    write(0, cloud);
    for (int i = 1; i < frames; ++i)
      std::filesystem::create_hard_link(in() / "0.ply", in() / fmt::format("{}.ply", i));
  }

  std::optional<VideoTrial> choose() {
    const auto trial = in_arena(2, [&]() -> Result<std::optional<VideoTrial>> {
      const auto sequence = list_cloud_frames(options_.inputs, options_.listing());
      if (!sequence) return tl::unexpected(sequence.error());
      return choose_video(sequence->frames, options_, {});
    });
    EXPECT_TRUE(trial) << trial.error().message;
    return trial.value_or(std::nullopt);
  }
};

/// A dense surface with colours that change slowly.
PointCloud smooth(std::size_t points = 210'000) {
  PointCloud cloud = ellipsoid(points);
  for (std::size_t i = 0; i < points; ++i)
    cloud.colors[i] = glm::u16vec3(32768.0f + 30000.0f * glm::sin(4.0f * cloud.positions[i]));
  return cloud;
}

/// No surface at all.
PointCloud fog() {
  std::mt19937 random(7);
  std::uniform_real_distribution<float> place(-1.0f, 1.0f);
  std::uniform_int_distribution<int> level(0, 65535);
  PointCloud cloud;
  for (int i = 0; i < 250'000; ++i) {
    cloud.positions.emplace_back(place(random), place(random), place(random));
    cloud.colors.emplace_back(level(random), level(random), level(random));
  }
  return cloud;
}

TEST_F(VideoTrialTest, a_dense_surface_becomes_video) {
  write_frames(smooth());
  const auto trial = choose();
  ASSERT_TRUE(trial);
  EXPECT_TRUE(trial->video_pays()) << testing::PrintToString(trial_lines(*trial));
  EXPECT_LT(trial->video.bytes, trial->octrees.bytes);
  ASSERT_TRUE(options_.video);
  EXPECT_EQ(options_.segment_frames, options_.video->segment_frames);
  EXPECT_THAT(trial_lines(*trial).front(), testing::HasSubstr("chosen          video"));
}

TEST_F(VideoTrialTest, what_is_no_surface_becomes_octrees) {
  write_frames(fog());
  const auto trial = choose();
  EXPECT_FALSE(trial && trial->video_pays());
  EXPECT_FALSE(options_.video);
}

TEST_F(VideoTrialTest, octrees_show_what_video_cannot_show_in_a_later_segment) {
  write_frames(smooth(), 15);
  PointCloud far = smooth();
  for (glm::vec3& at : far.positions) at.x += 1000.0f;
  write(15, far);
  options_.video_if_it_pays->segment_frames = 8;
  const PackSummary summary = packed();
  EXPECT_EQ(summary.codec, "octree");
  EXPECT_EQ(summary.frames, 16u);
  EXPECT_FALSE(summary.trial);
  EXPECT_THAT(summary.warnings,
              testing::Contains(testing::HasSubstr(
                  "packed as octrees, because video does not suit all frames: ")));
}

TEST_F(VideoTrialTest, octrees_keep_voxels_that_pixels_of_a_larger_cube_would_merge) {
  PointCloud voxels = smooth();
  for (glm::vec3& at : voxels.positions) at = glm::round(300.0f * at);
  write_frames(voxels, 15);
  for (glm::vec3& at : voxels.positions) at.x += 30'000.0f;
  write(15, voxels);
  const PackSummary summary = packed();
  EXPECT_EQ(summary.codec, "octree");
  EXPECT_EQ(summary.max_error, 0.0);
}

TEST_F(VideoTrialTest, octrees_keep_scalar_fields_that_only_other_frames_have) {
  write_frames(smooth(), 15);
  PointCloud cloud = smooth();
  cloud.scalars.push_back({"intensity", {}});
  for (std::size_t i = 0; i < cloud.size(); ++i)
    cloud.scalars[0].values.push_back(static_cast<float>(i % 100));
  write(15, cloud);
  const PackSummary summary = packed();
  EXPECT_EQ(summary.codec, "octree");
  EXPECT_GT(summary.scalar_bytes, 0u);
}

TEST_F(VideoTrialTest, all_parts_of_a_plan_agree) {
  write_frames(smooth());
  const auto plan = make_plan(options_, {"--threads=2"});
  ASSERT_TRUE(plan) << plan.error().message;
  const auto read = read_plan(options_.output);
  ASSERT_TRUE(read);
  EXPECT_THAT(read->arguments, testing::Contains("--codec=video"));
  EXPECT_EQ(read->segment_frames, options_.video_if_it_pays->segment_frames);
}

TEST_F(VideoTrialTest, short_sequences_are_not_tried) {
  write_frames(smooth(), 15);
  EXPECT_FALSE(choose());
}

TEST_F(VideoTrialTest, sparse_frames_are_not_tried) {
  write_frames(smooth(20'000));
  EXPECT_FALSE(choose());
}

TEST_F(VideoTrialTest, scalar_fields_are_kept) {
  PointCloud cloud = smooth();
  cloud.scalars.push_back({"intensity", {}});
  for (std::size_t i = 0; i < cloud.size(); ++i)
    cloud.scalars[0].values.push_back(static_cast<float>(i % 100));
  write_frames(cloud);
  EXPECT_FALSE(choose());
}

}  // namespace
}  // namespace pointreel::video_trial_test
