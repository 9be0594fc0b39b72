#include "codec/files/las.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace pointreel::las_test {
namespace {

using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;

constexpr std::array<std::uint16_t, 11> kSizes{20, 28, 26, 34, 57, 63, 30, 36, 38, 59, 67};
constexpr std::array<std::size_t, 11> kColors{0, 0, 20, 28, 0, 28, 0, 30, 30, 0, 30};

template <class T>
void set(Bytes& bytes, std::size_t at, T value) {
  std::memcpy(bytes.data() + at, &value, sizeof(value));
}

/// A file with points whose last coordinates are 1 m apart.
Bytes las(std::uint8_t minor, std::uint8_t format, std::size_t extra = 0,
          std::uint16_t brightness = 65535, std::size_t count = 3) {
  const std::size_t header = minor == 4 ? 375 : minor == 3 ? 235 : 227;
  const std::size_t size = kSizes[format] + extra;
  Bytes bytes(header + count * size);
  std::memcpy(bytes.data(), "LASF", 4);
  bytes[24] = 1;
  bytes[25] = minor;
  bytes[104] = format;
  set(bytes, 94, static_cast<std::uint16_t>(header));
  set(bytes, 96, static_cast<std::uint32_t>(header));
  set(bytes, 105, static_cast<std::uint16_t>(size));
  if (minor == 4) {
    set(bytes, 247, static_cast<std::uint64_t>(count));
  } else {
    set(bytes, 107, static_cast<std::uint32_t>(count));
  }
  for (std::size_t axis = 0; axis < 3; ++axis) {
    set(bytes, 131 + 8 * axis, 0.001);
    set(bytes, 155 + 8 * axis, 500000.25);
  }
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t at = header + i * size;
    set(bytes, at, std::int32_t{-1234567});
    set(bytes, at + 4, std::int32_t{7654321});
    set(bytes, at + 8, static_cast<std::int32_t>(1000 * i));
    set(bytes, at + 12, static_cast<std::uint16_t>(500 + i));
    bytes[at + 14] = format < 6 ? 0xfd : 0xf5;  // return 5, and other bits
    bytes[at + (format < 6 ? 15 : 16)] = 0xe6;
    if (kColors[format] > 0)
      set(bytes, at + kColors[format] + 2, static_cast<std::uint16_t>(brightness / (i + 1)));
  }
  return bytes;
}

Result<PointCloud> read(const Bytes& bytes, std::vector<std::string>* unread = nullptr) {
  ReadNotes notes;
  const Result<PointCloud> cloud = read_las(ByteSource(ByteView(bytes)), notes);
  if (unread != nullptr) *unread = notes.unread;
  return cloud;
}

std::string error_of(const Bytes& bytes) {
  const Result<PointCloud> cloud = read(bytes);
  return cloud ? "it was read" : cloud.error().message;
}

TEST(Las, all_versions_and_point_formats_are_read) {
  for (std::uint8_t minor = 0; minor <= 4; ++minor) {
    for (std::uint8_t format = 0; format <= (minor == 4 ? 10 : 5); ++format) {
      for (const std::size_t extra : {0, 5}) {
        std::vector<std::string> unread;
        const Result<PointCloud> cloud = read(las(minor, format, extra), &unread);
        ASSERT_TRUE(cloud) << cloud.error().message;
        ASSERT_EQ(cloud->size(), 3u);
        for (std::size_t i = 0; i < 3; ++i) {
          const glm::dvec3 expected(500000.25 - 1234.567, 500000.25 + 7654.321,
                                    500000.25 + static_cast<double>(i));
          EXPECT_LT(glm::length(cloud->world(i) - expected), 1e-6);
        }
        EXPECT_EQ(cloud->has_colors(), kColors[format] > 0) << int{format};
        if (cloud->has_colors()) {
          EXPECT_THAT(cloud->colors,
                      ElementsAre(glm::u16vec3(0, 65535, 0), glm::u16vec3(0, 32767, 0),
                                  glm::u16vec3(0, 21845, 0)));
        }
        EXPECT_THAT(unread, Contains("scan angle"));
        const bool old = format < 6;
        EXPECT_EQ(cloud->scalars.at(0), (ScalarField{"intensity", {500, 501, 502}}));
        EXPECT_EQ(cloud->scalars.at(1), (ScalarField{"return number", {5, 5, 5}}));
        const float label = old ? 6.0f : 0xe6;
        EXPECT_EQ(cloud->scalars.at(2), (ScalarField{"classification", {label, label, label}}));
        EXPECT_EQ(std::count(unread.begin(), unread.end(), "extra bytes"), extra > 0 ? 1 : 0);
      }
    }
  }
}

/// How many points are read of a file whose header says `count`, and the warning.
std::pair<std::size_t, std::string> with_count(Bytes bytes, std::uint32_t count) {
  set(bytes, 107, count);
  ReadNotes notes;
  const Result<PointCloud> cloud = read_las(ByteSource(ByteView(bytes)), notes);
  if (!cloud) return {0, cloud.error().message};
  return {cloud->size(), notes.warnings.empty() ? "" : notes.warnings[0]};
}

TEST(Las, points_that_the_header_does_not_count_are_read_with_a_warning) {
  using testing::Pair;
  EXPECT_THAT(with_count(las(2, 2), 3), Pair(3u, ""));
  EXPECT_THAT(with_count(las(2, 2), 0),
              Pair(3u, "the header says 0 points, but there are 3: all are read"));
  EXPECT_THAT(with_count(las(2, 2), 1),
              Pair(3u, "the header says 1 points, but there are 3: all are read"));
  Bytes other = las(2, 2);
  other.push_back(0);
  EXPECT_THAT(with_count(other, 1), Pair(1u, HasSubstr("53 bytes behind them that are not read")));
  EXPECT_THAT(with_count(other, 3), Pair(3u, ""));
  EXPECT_THAT(with_count(las(2, 2), 4), Pair(0u, HasSubstr("the data end within point 3 of 4")));
}

TEST(Las, records_after_the_points_are_no_points) {
  Bytes bytes = las(4, 6);
  set(bytes, 235, static_cast<std::uint64_t>(bytes.size()));
  set(bytes, 243, std::uint32_t{1});
  bytes.resize(bytes.size() + 60);
  ReadNotes notes;
  EXPECT_EQ(read_las(ByteSource(ByteView(bytes)), notes).value().size(), 3u);
  EXPECT_TRUE(notes.warnings.empty());
}

TEST(Las, colors_that_were_stored_as_bytes_are_taken_as_bytes) {
  const Result<PointCloud> cloud = read(las(2, 2, 0, 255));
  ASSERT_TRUE(cloud) << cloud.error().message;
  EXPECT_EQ(cloud->colors[0], glm::u16vec3(0, 65535, 0));
  EXPECT_EQ(cloud->colors[1], glm::u16vec3(0, 127 * 257, 0));
}

TEST(Las, colors_that_are_all_zero_were_not_measured) {
  std::vector<std::string> unread;
  const Result<PointCloud> cloud = read(las(2, 2, 0, 0), &unread);
  ASSERT_TRUE(cloud) << cloud.error().message;
  EXPECT_FALSE(cloud->has_colors());
  EXPECT_THAT(unread, testing::Contains("colours (0 at all points)"));
}

TEST(Las, a_point_at_zero_does_not_cost_the_others_their_precision) {
  Bytes bytes = las(2, 0, 0, 0, 100);
  for (std::size_t axis = 0; axis < 3; ++axis) set(bytes, 227 + 4 * axis, std::int32_t{-500000250});
  const Result<PointCloud> cloud = read(bytes);
  ASSERT_TRUE(cloud) << cloud.error().message;
  EXPECT_NEAR(cloud->world(2).y, 500000.25 + 7654.321, 1e-6);
}

TEST(Las, the_count_of_version_1_4_counts_where_there_are_two) {
  Bytes bytes = las(4, 6);
  set(bytes, 107, std::uint32_t{2});
  EXPECT_EQ(read(bytes)->size(), 3u);
  set(bytes, 247, std::uint64_t{0});
  ReadNotes notes;
  EXPECT_EQ(read_las(ByteSource(ByteView(bytes)), notes).value().size(), 3u);
  EXPECT_THAT(notes.warnings, testing::ElementsAre(testing::HasSubstr("says 2 points")));
}

TEST(Las, compressed_files_are_refused_with_the_way_to_convert_them) {
  for (const int bit : {0x80, 0x40}) {
    Bytes bytes = las(2, 2);
    bytes[104] = static_cast<std::uint8_t>(bytes[104] | bit);
    const Result<PointCloud> cloud = read(bytes);
    ASSERT_FALSE(cloud);
    EXPECT_EQ(cloud.error().code, ErrorCode::unsupported);
    EXPECT_THAT(cloud.error().message, HasSubstr("pdal translate"));
  }
}

TEST(Las, each_lie_of_the_header_is_an_error_that_says_where) {
  const auto with = [](std::size_t at, auto value) {
    Bytes bytes = las(4, 7);
    set(bytes, at, value);
    return error_of(bytes);
  };
  EXPECT_THAT(with(25, std::uint8_t{5}), HasSubstr("version 1.5"));
  EXPECT_THAT(with(24, std::uint8_t{2}), HasSubstr("version 2.4"));
  EXPECT_THAT(with(104, std::uint8_t{11}), HasSubstr("byte 104: has the point format 11"));
  EXPECT_THAT(with(105, std::uint16_t{35}),
              HasSubstr("byte 105: points of 35 bytes are too short"));
  EXPECT_THAT(with(105, std::uint16_t{0}), HasSubstr("too short"));
  EXPECT_THAT(with(96, std::uint32_t{200}), HasSubstr("byte 96: the points begin at byte 200"));
  EXPECT_THAT(with(96, std::uint32_t{4000000000u}), HasSubstr("the data end within point 0 of 3"));
  EXPECT_THAT(with(247, std::uint64_t{4}), HasSubstr("the data end within point 3 of 4"));
  EXPECT_THAT(with(247, ~std::uint64_t{0}), HasSubstr("the data end within point 3"));
  EXPECT_THAT(with(131, 0.0), HasSubstr("byte 131: the scale"));
  EXPECT_THAT(with(139, std::nan("")), HasSubstr("byte 131: the scale"));
  EXPECT_THAT(with(155, std::numeric_limits<double>::infinity()), HasSubstr("byte 155"));
}

TEST(Las, any_part_of_a_file_is_refused_in_one_line) {
  const Bytes whole = las(4, 7);
  for (std::size_t size = 0; size < whole.size(); ++size) {
    const Result<PointCloud> cloud =
        read(Bytes(whole.begin(), whole.begin() + static_cast<int>(size)));
    ASSERT_FALSE(cloud) << size;
    EXPECT_EQ(cloud.error().message.find('\n'), std::string::npos);
  }
}

}  // namespace
}  // namespace pointreel::las_test
