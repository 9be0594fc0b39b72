#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "codec/distance/distance.h"
#include "codec/files/cloud_file.h"
#include "codec/package/manifest.h"
#include "codec/package/max_error.h"
#include "codec/segments/coding_error.h"
#include "pointreel/draco.h"
#include "server/inspect/inspect.h"
#include "server/pack/packer.h"
#include "tests/packed_clouds.h"

namespace pointreel::pack_control_test {
namespace {

namespace fs = std::filesystem;
using testing::IsEmpty;

class PackControl : public testing::Test {
 protected:
  PackOptions options(std::size_t frames, std::size_t points) {
    write_frames(folder_.path() / "in", frames, points);
    PackOptions options = pack_options(folder_.path() / "in", folder_.path() / "reel");
    options.force = true;
    return options;
  }

  static PackSummary packed(const PackOptions& options) {
    const Result<PackSummary> summary = pack(options);
    if (!summary) ADD_FAILURE() << summary.error().message;
    return summary.value_or(PackSummary{});
  }

  static const OctreeOptions& octree(const SegmentSummary& segment) {
    return std::get<OctreeOptions>(segment.encode.codec);
  }

  TemporaryFolder folder_;
};

TEST_F(PackControl, keeps_every_segment_within_the_bit_rate_and_close_to_it) {
  constexpr int kQuality = 50;
  PackOptions options = this->options(7, 4000);
  options.segment_frames = 3;
  std::get<OctreeOptions>(options.encode.codec).color_quality = kQuality;
  const double free_rate = packed(options).segments.front().bits_per_second;
  for (const double share : {0.9, 0.5, 0.2, 0.05}) {
    options.bitrate = share * free_rate;
    const PackSummary summary = packed(options);
    ASSERT_EQ(summary.segments.size(), 3u);
    EXPECT_THAT(summary.warnings, IsEmpty());
    for (const SegmentSummary& segment : summary.segments) {
      EXPECT_LE(segment.bits_per_second, *options.bitrate) << share;
      EXPECT_GE(segment.bits_per_second, 0.3 * *options.bitrate) << share;
      EXPECT_TRUE(segment.within_rate);
      EXPECT_LE(segment.trials, 12);
      // Attributes lose at most twice as much as voxels do.
      const int levels = 10 - static_cast<int>(segment.depth_max);
      EXPECT_GE(octree(segment).color_quality, kQuality - 14 * (levels + 1));
    }
    const Result<VerifyReport> report = verify(options.output);
    ASSERT_TRUE(report);
    EXPECT_THAT(report->faults, IsEmpty());
    const Manifest manifest = read_manifest(options.output).value();
    EXPECT_EQ(manifest.depth_min, summary.depth_min);
    EXPECT_EQ(manifest.depth_max, summary.depth_max);
  }
}

TEST_F(PackControl, writes_the_same_bytes_on_any_number_of_threads_at_a_bit_rate) {
  PackOptions options = this->options(6, 2000);
  options.segment_frames = 4;
  options.bitrate = 0.3 * packed(options).segments.front().bits_per_second;
  options.threads = 1;
  packed(options);
  const auto alone = contents(options.output);
  options.threads = 4;
  packed(options);
  EXPECT_EQ(contents(options.output), alone);
}

TEST_F(PackControl, changes_nothing_if_the_bit_rate_is_sufficient) {
  PackOptions options = this->options(2, 1000);
  packed(options);
  const auto free = contents(options.output);
  options.bitrate = 1e12;
  EXPECT_EQ(packed(options).segments.front().trials, 1);
  EXPECT_EQ(contents(options.output), free);
}

TEST_F(PackControl, rewrites_a_segment_if_its_sampled_frames_were_unusually_small) {
  PackOptions options = this->options(0, 0);
  for (std::size_t i = 0; i < 9; ++i) {
    // Of nine frames, the trials encode frames 1, 3, 5 and 7.
    const std::size_t points = i % 2 == 1 ? 500 : 6000;
    ASSERT_TRUE(write_ply(folder_.path() / "in" / fmt::format("{}.ply", i), ellipsoid(points)));
  }
  int ticks = 0;
  PackListener listener;
  listener.frame_done = [&] { ++ticks; };
  options.bitrate = 0.5 * packed(options).segments.front().bits_per_second;
  const Result<PackSummary> summary = pack(options, listener);
  ASSERT_TRUE(summary);
  EXPECT_LE(summary->segments.front().bits_per_second, *options.bitrate);
  EXPECT_EQ(summary->segments.size(), 1u);
  EXPECT_EQ(summary->frames, 9u);
  EXPECT_EQ(ticks, 9);
  EXPECT_THAT(verify(options.output)->faults, IsEmpty());
  // Nothing remains of the first attempt.
  std::uint64_t bytes = 0;
  for (const auto& entry : fs::directory_iterator(options.output)) bytes += entry.file_size();
  EXPECT_EQ(bytes, summary->bytes);
}

TEST_F(PackControl, also_controls_draco_voxels_and_a_cube_for_each_frame) {
  PackOptions options = this->options(3, 3000);
  options.cube_per_frame = true;
  options.bitrate = 0.5 * packed(options).segments.front().bits_per_second;
  EXPECT_TRUE(packed(options).segments.front().within_rate);
  options.voxel = 0.01;
  EXPECT_TRUE(packed(options).segments.front().within_rate);
  options.voxel.reset();
  options.bitrate.reset();
  options.encode.codec = DracoOptions{};
  const double free_rate = packed(options).segments.front().bits_per_second;
  options.bitrate = 0.8 * free_rate;
  const SegmentSummary segment = packed(options).segments.front();
  EXPECT_TRUE(segment.within_rate);
  EXPECT_LT(segment.depth_max, 11u);
}

// The result depends on no clock: any machine takes longer than 1e-9 ms and less than 1e9 ms.
TEST_F(PackControl, lowers_the_depth_if_frames_take_too_long) {
  PackOptions options = this->options(20, 400);
  options.threads = 1;
  options.frame_time_ms = 1e9;
  PackSummary summary = packed(options);
  EXPECT_EQ(summary.depth_min, 10u);
  EXPECT_EQ(summary.late_frames, 0u);
  options.frame_time_ms = 1e-9;
  summary = packed(options);
  EXPECT_EQ(summary.late_frames, 20u);
  EXPECT_EQ(summary.depth_max, 10u);
  EXPECT_EQ(summary.depth_min, 1u);
  EXPECT_THAT(verify(options.output)->faults, IsEmpty());
}

TEST_F(PackControl, compares_a_frame_of_a_second_with_its_source) {
  EXPECT_EQ(compared_frame(0, 24), 12u);
  EXPECT_EQ(compared_frame(24, 24), 12u) << "in which frame 30 is";
  EXPECT_EQ(compared_frame(31, 24), std::nullopt);
  PackOptions options = this->options(5, 2000);
  options.segment_frames = 4;
  const PackSummary summary = packed(options);
  const Manifest manifest = read_manifest(options.output).value();
  ASSERT_TRUE(manifest.coding_error);
  EXPECT_EQ(manifest.coding_error, summary.coding_error);
  const auto source = read_cloud_file(folder_.path() / "in" / "frame_2.ply");
  const auto back = decode_frame(layer_views(*read_frame(options.output, manifest, 2, SIZE_MAX)));
  const CloudDistance distance = cloud_distance(source->cloud, back->cloud).value();
  EXPECT_EQ(manifest.coding_error->frames, 1u);
  EXPECT_EQ(manifest.coding_error->d1, distance.d1());
  EXPECT_GT(distance.d1(), 0.0);
  EXPECT_EQ(manifest.coding_error->luma, distance.colors()->x);
}

TEST(AddCodingError, weighs_by_frames_and_keeps_what_all_have) {
  std::optional<CodingError> sum;
  add_coding_error(sum, {1, 2.0, 1.0, 8.0});
  add_coding_error(sum, {3, 6.0, 5.0, {}});
  EXPECT_EQ(sum, (CodingError{4, 5.0, 4.0, {}}));
  EXPECT_EQ(coding_error_text({1, 0.0, {}, 65.025}, 10.0),
            "D1 without loss, luma 30.0 dB (1 frame compared)");
}

TEST_F(PackControl, reports_the_largest_error_and_stores_it_in_the_package) {
  PackOptions options = this->options(4, 2000);
  options.segment_frames = 2;
  for (const bool cube_per_frame : {false, true}) {
    options.cube_per_frame = cube_per_frame;
    const PackSummary summary = packed(options);
    const Manifest manifest = read_manifest(options.output).value();
    const Result<double> told = max_error(options.output, manifest);
    ASSERT_TRUE(told);
    EXPECT_EQ(*told, summary.max_error);
    EXPECT_EQ(summary.max_error,
              std::max(summary.segments[0].max_error, summary.segments[1].max_error));
    double most = 0.0;
    for (std::uint32_t i = 0; i < 4; ++i) {
      const auto source = read_cloud_file(folder_.path() / "in" / fmt::format("frame_{}.ply", i));
      const auto layers = read_frame(options.output, manifest, i, SIZE_MAX);
      const auto back = decode_frame(layer_views(*layers));
      most = std::max(most, cloud_distance(source->cloud, back->cloud)->max());
    }
    EXPECT_LE(most, summary.max_error);
    EXPECT_GT(most, 0.8 * summary.max_error);
  }
  // Of packages that do not say it, the headers of the frames tell a bound.
  Manifest manifest = read_manifest(options.output).value();
  const double measured = manifest.max_error.value();
  manifest.max_error.reset();
  const Result<double> bound = max_error(options.output, manifest);
  ASSERT_TRUE(bound);
  EXPECT_GE(*bound, measured);
  EXPECT_LE(*bound, 1.25 * measured);
  fs::remove(options.output / manifest.segments[1].layers[0].path);
  EXPECT_FALSE(max_error(options.output, manifest));
}

}  // namespace
}  // namespace pointreel::pack_control_test
