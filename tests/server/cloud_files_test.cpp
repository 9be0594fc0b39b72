#include <limits>
#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "codec/files/cloud_file.h"
#include "codec/files/write_cloud.h"

namespace pointreel::cloud_files_test {
namespace {

PointCloud far_cloud() {
  PointCloud cloud;
  cloud.origin = {500000.0, 5400000.0, 100.0};
  cloud.positions = {{0.25f, 0.5f, -1.125f}, {1.0f, 2.0f, 3.0f}};
  cloud.normals = {{0, 0, 1}, {0, 1, 0}};
  cloud.colors = {{65535, 257, 0}, {0, 0, 514}};
  cloud.scalars = {{"intensity", {12, 700}}, {"surface height", {0.5f, -2}}};
  return cloud;
}

LoadedCloud again(const PointCloud& cloud, PointsFormat format) {
  const auto bytes = cloud_bytes(cloud, format);
  auto loaded = read_cloud(bytes.value());
  EXPECT_TRUE(loaded) << loaded.error().message;
  return std::move(*loaded);
}

TEST(CloudFiles, what_is_written_is_read_again) {
  const PointCloud cloud = far_cloud();
  for (const PointsFormat format : {PointsFormat::ply, PointsFormat::pcd, PointsFormat::las}) {
    const PointCloud read = again(cloud, format).cloud;
    ASSERT_EQ(read.size(), 2u);
    for (std::size_t i = 0; i < 2; ++i)
      EXPECT_LT(glm::length(read.world(i) - cloud.world(i)), 1e-7) << extension(format);
    EXPECT_EQ(read.colors, cloud.colors) << extension(format);
    EXPECT_EQ(read.scalars.at(0), cloud.scalars[0]) << extension(format);
    if (format != PointsFormat::las) {
      EXPECT_EQ(read.normals, cloud.normals);
      EXPECT_EQ(read.scalars.at(1).values, cloud.scalars[1].values);
    }
  }
}

TEST(CloudFiles, las_holds_small_things_and_large_ones) {
  for (const double corner : {0.0, -0.3, 0.987, 512345.67}) {
    for (double size = 1e-6; size < 1e6; size *= 2.7) {
      PointCloud cloud;
      cloud.origin = glm::dvec3(corner, -corner, 0.5 * corner);
      for (int i = 0; i <= 8; ++i)
        cloud.positions.emplace_back(size * glm::dvec3(i / 8.0, (i % 3) / 2.0, -i / 8.0));
      const PointCloud read = again(cloud, PointsFormat::las).cloud;
      ASSERT_EQ(read.size(), cloud.size());
      for (std::size_t i = 0; i < cloud.size(); ++i)
        EXPECT_LT(glm::length(read.world(i) - cloud.world(i)), 1e-6 * size + 1e-15 * corner + 1e-9)
            << corner << ", " << size;
    }
  }
}

TEST(CloudFiles, clouds_without_points_and_with_one_are_files_too) {
  PointCloud cloud;
  for (const PointsFormat format : {PointsFormat::ply, PointsFormat::pcd, PointsFormat::las})
    EXPECT_TRUE(again(cloud, format).cloud.empty());
  cloud.positions = {{1, 2, 3}};
  for (const PointsFormat format : {PointsFormat::ply, PointsFormat::pcd, PointsFormat::las})
    EXPECT_EQ(again(cloud, format).cloud.world(0), glm::dvec3(1, 2, 3));
  EXPECT_TRUE(npz_bytes(cloud));
}

TEST(CloudFiles, what_las_clips_or_drops_is_counted_by_field) {
  PointCloud cloud;
  const float unknown = std::numeric_limits<float>::quiet_NaN();
  cloud.positions.resize(4);
  cloud.scalars = {{"intensity", {0, 65535.4f, 65536, -1}},
                   {"classification", {31, 2, 32, unknown}},
                   {"return number", {1, 7, 1, 2}},
                   {"heat", {1, 2, 3, 4}}};
  const auto lost = lost_in_las(cloud);
  ASSERT_EQ(lost.size(), 3u);
  EXPECT_EQ(lost[0].field, "intensity");
  EXPECT_EQ(lost[0].values, 2u);
  EXPECT_EQ(lost[0].bounds, std::pair(0, 65535));
  EXPECT_EQ(lost[1].field, "classification");
  EXPECT_EQ(lost[1].values, 2u);
  EXPECT_EQ(lost[2].field, "heat");
  EXPECT_EQ(lost[2].values, 4u);
  EXPECT_FALSE(lost[2].bounds);
  // And this is what happens to them.
  const PointCloud read = again(cloud, PointsFormat::las).cloud;
  EXPECT_EQ(read.scalars.at(0).values, (std::vector<float>{0, 65535, 65535, 0}));
}

TEST(CloudFiles, npz_is_a_zip_of_arrays_aligned_to_64_bytes) {
  const Bytes bytes = npz_bytes(far_cloud()).value();
  const std::string text(bytes.begin(), bytes.end());
  EXPECT_TRUE(text.starts_with("PK\x03\x04"));
  for (const char* part :
       {"positions.npy", "'descr': '<f8'", "'shape': (2, 3)", "colors.npy", "'<u2'", "normals.npy",
        "intensity.npy", "'shape': (2,)", "surface_height.npy"})
    EXPECT_NE(text.find(part), std::string::npos) << part;
  const std::size_t array = text.find("\x93NUMPY");
  const std::size_t numbers = text.find('\n', array) + 1;
  EXPECT_EQ((numbers - array) % 64, 0u);
}

}  // namespace
}  // namespace pointreel::cloud_files_test
