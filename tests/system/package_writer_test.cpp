#include "codec/segments/package_writer.h"

#include <filesystem>
#include <limits>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "client/source/file_source.h"
#include "codec/files/cloud_file.h"
#include "pointreel/draco.h"
#include "server/inspect/inspect.h"
#include "tests/packed_clouds.h"

namespace pointreel::package_writer_test {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

class PackageWriterTest : public testing::Test {
 protected:
  PackOptions options() const {
    PackOptions options;
    options.output = reel_;
    options.segment_frames = 3;
    options.fps = 25.0;
    options.encode.codec = OctreeOptions{Entropy::zstd, DepthRule::fixed(10)};
    return options;
  }

  /// The error of writing `frames` clouds, or an empty text.
  std::string write(const PackOptions& options, int frames) {
    auto writer = PackageWriter::create(options);
    if (!writer) return writer.error().message;
    for (int i = 0; i < frames; ++i) {
      if (auto added = writer->add(cloud(i)); !added) return added.error().message;
    }
    const auto finished = writer->finish();
    return finished ? "" : finished.error().message;
  }

  static PointCloud cloud(int frame) {
    return ellipsoid(100 + static_cast<std::size_t>(frame),
                     glm::dvec3(0.25 * static_cast<double>(frame), 1.0, -2.0));
  }

  TemporaryFolder folder_;
  const fs::path reel_ = folder_.path() / "some.reel";
};

TEST_F(PackageWriterTest, writes_the_package_that_pack_makes_of_the_same_clouds_in_files) {
  const fs::path frames = folder_.path() / "frames", packed = folder_.path() / "packed";
  write_frames(frames, 7);
  PackOptions from_files = pack_options(frames, packed);
  from_files.segment_frames = 3;
  from_files.name = "same";
  ASSERT_TRUE(pack(from_files));

  PackOptions same = options();
  same.name = "same";
  auto writer = PackageWriter::create(same);
  ASSERT_TRUE(writer) << writer.error().message;
  for (int i = 0; i < 7; ++i) {
    auto loaded = read_cloud_file(frames / ("frame_" + std::to_string(i) + ".ply"));
    ASSERT_TRUE(loaded);
    ASSERT_TRUE(writer->add(std::move(loaded->cloud)));
  }
  ASSERT_TRUE(writer->finish());
  EXPECT_EQ(contents(reel_), contents(packed));
}

TEST_F(PackageWriterTest, writes_packages_of_either_codec_that_are_in_order) {
  for (const bool draco : {false, true}) {
    PackOptions write_options = options();
    if (draco) write_options.encode.codec = DracoOptions{};
    write_options.force = draco;
    ASSERT_EQ(write(write_options, 4), "");
    const auto report = verify(reel_);
    ASSERT_TRUE(report) << report.error().message;
    EXPECT_EQ(report->frames, 4u);
    EXPECT_TRUE(report->faults.empty());
  }
}

TEST_F(PackageWriterTest, keeps_the_times_that_are_given) {
  auto writer = PackageWriter::create(options());
  ASSERT_TRUE(writer);
  for (const std::uint64_t time : {0u, 10'000u, 10'000u, 500'000u})
    ASSERT_TRUE(writer->add(cloud(0), time));
  ASSERT_FALSE(writer->add(cloud(0), 400'000u));
  ASSERT_TRUE(writer->add(cloud(0)));
  ASSERT_TRUE(writer->finish());
  const auto source = open_file_source(reel_);
  ASSERT_TRUE(source) << source.error().message;
  const Manifest& manifest = (*source)->manifest();
  EXPECT_EQ(frame_time_us(manifest, 1), 10'000u);
  EXPECT_EQ(frame_time_us(manifest, 3), 500'000u);
  EXPECT_EQ(frame_time_us(manifest, 4), 540'000u);
  EXPECT_EQ(manifest.duration_us, 580'000u);
}

TEST_F(PackageWriterTest, leaves_nothing_behind_unless_it_was_finished) {
  {
    auto writer = PackageWriter::create(options());
    ASSERT_TRUE(writer);
    for (int i = 0; i < 5; ++i) ASSERT_TRUE(writer->add(cloud(i)));
  }
  EXPECT_TRUE(fs::is_empty(folder_.path()));
}

TEST_F(PackageWriterTest, writes_nothing_more_once_it_was_stopped) {
  auto writer = PackageWriter::create(options());
  ASSERT_TRUE(writer);
  std::stop_source stop;
  stop.request_stop();
  ASSERT_TRUE(writer->add(cloud(0)));
  const auto stopped = writer->finish(stop.get_token());
  ASSERT_FALSE(stopped);
  EXPECT_EQ(stopped.error().code, ErrorCode::cancelled);
  EXPECT_FALSE(writer->add(cloud(0)));
  EXPECT_FALSE(writer->finish());
}

TEST_F(PackageWriterTest, leaves_out_points_that_are_nowhere) {
  PointCloud broken = cloud(0);
  broken.positions[3].x = std::numeric_limits<float>::quiet_NaN();
  auto writer = PackageWriter::create(options());
  ASSERT_TRUE(writer);
  ASSERT_TRUE(writer->add(std::move(broken)));
  ASSERT_TRUE(writer->add(PointCloud{}));
  ASSERT_TRUE(writer->finish());
  const auto source = open_file_source(reel_);
  ASSERT_TRUE(source);
  EXPECT_EQ((*source)->manifest().segments[0].points[0], 99u);
  EXPECT_EQ((*source)->manifest().segments[0].points[1], 0u);
}

TEST_F(PackageWriterTest, refuses_what_no_player_would_take) {
  EXPECT_THAT(write(options(), 0), HasSubstr("at least one frame"));
  PackOptions wrong = options();
  wrong.fps = 0.0;
  EXPECT_THAT(write(wrong, 1), HasSubstr("frames per second"));
  wrong = options();
  wrong.segment_frames = 0;
  EXPECT_THAT(write(wrong, 1), HasSubstr("at least one frame"));
  wrong = options();
  wrong.name = std::string(100'000, 'a');
  EXPECT_NE(write(wrong, 1), "");
  EXPECT_FALSE(fs::exists(reel_));
  ASSERT_EQ(write(options(), 1), "");
  EXPECT_THAT(write(options(), 1), HasSubstr("exists"));
}

}  // namespace
}  // namespace pointreel::package_writer_test
