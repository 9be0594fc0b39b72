#include "codec/files/recording_writer.h"

#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "codec/files/cloud_file.h"
#include "tests/temporary_folder.h"

namespace pointreel::recording_writer_test {
namespace {

using testing::ElementsAre;

PointCloud cloud_at(float x, const glm::dvec3& origin) {
  PointCloud cloud;
  cloud.origin = origin;
  cloud.positions = {{x, 0.5f, -1.125f}, {1.0f, 2.0f, 3.0f}};
  cloud.normals = {{0, 0, 1}, {0, 1, 0}};
  cloud.colors = {{65535, 257, 0}, {0, 0, 514}};
  cloud.scalars = {{"intensity", {12.5f, 70000}}, {"rgb", {0.5f, -2}}};
  return cloud;
}

TEST(RecordingWriter, what_is_written_is_read_again_at_its_time) {
  const TemporaryFolder folder;
  const std::vector<std::uint64_t> times{2'000'000, 2'033'333, 5'000'001};
  for (const glm::dvec3& origin : {glm::dvec3(0.0), glm::dvec3(500000.0, 5400000.1, 100.0)}) {
    RecordingWriter writer(folder / "a.mcap");
    for (std::size_t i = 0; i < times.size(); ++i) {
      const auto frame = record_frame(cloud_at(static_cast<float>(i), origin), times[i]);
      ASSERT_TRUE(frame) << frame.error().message;
      ASSERT_TRUE(writer.add(*frame));
    }
    ASSERT_TRUE(writer.finish());
    const auto sequence = list_cloud_frames({folder / "a.mcap"});
    ASSERT_TRUE(sequence) << sequence.error().message;
    EXPECT_THAT(sequence->times_us, ElementsAre(0, 33'333, 3'000'001));
    ASSERT_EQ(sequence->frames.size(), times.size());
    for (std::size_t i = 0; i < times.size(); ++i) {
      const auto loaded = read_cloud_frame(sequence->frames[i]);
      ASSERT_TRUE(loaded) << loaded.error().message;
      const PointCloud& read = loaded->cloud;
      const PointCloud cloud = cloud_at(static_cast<float>(i), origin);
      ASSERT_EQ(read.size(), cloud.size());
      for (std::size_t j = 0; j < cloud.size(); ++j)
        EXPECT_LT(glm::length(read.world(j) - cloud.world(j)), 1e-7);
      EXPECT_EQ(read.colors, cloud.colors);
      EXPECT_EQ(read.normals, cloud.normals);
      ASSERT_EQ(read.scalars.size(), 2u);
      EXPECT_EQ(read.scalars[0], cloud.scalars[0]);
      EXPECT_EQ(read.scalars[1].values, cloud.scalars[1].values);
      EXPECT_EQ(read.scalars[1].name, "rgb_");
    }
  }
}

TEST(RecordingWriter, frames_without_points_are_messages_too) {
  const TemporaryFolder folder;
  RecordingWriter writer(folder / "a.mcap");
  ASSERT_TRUE(writer.add(record_frame(PointCloud{}, 0).value()));
  ASSERT_TRUE(writer.finish());
  const auto sequence = list_cloud_frames({folder / "a.mcap"});
  ASSERT_TRUE(sequence) << sequence.error().message;
  EXPECT_TRUE(read_cloud_frame(sequence->frames.at(0)).value().cloud.empty());
}

TEST(RecordingWriter, a_file_that_cannot_be_written_is_an_error_with_its_path) {
  const TemporaryFolder folder;
  RecordingWriter writer(folder / "missing/a.mcap");
  const auto added = writer.add(record_frame(PointCloud{}, 0).value());
  ASSERT_FALSE(added);
  EXPECT_EQ(added.error().code, ErrorCode::io);
  EXPECT_THAT(added.error().message, testing::StartsWith((folder / "missing/a.mcap").string()));
}

}  // namespace
}  // namespace pointreel::recording_writer_test
