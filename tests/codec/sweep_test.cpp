#include "codec/formats/sweep.h"

#include <cmath>
#include <cstring>
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace pointreel::sweep_test {
namespace {

using testing::HasSubstr;

Bytes bytes_of(const std::vector<float>& numbers) {
  Bytes bytes(numbers.size() * sizeof(float));
  std::memcpy(bytes.data(), numbers.data(), bytes.size());
  return bytes;
}

/// `points` points of `floats` numbers, the last of which are rings or shares.
std::vector<float> sweep(std::size_t points, std::size_t floats) {
  std::vector<float> numbers;
  for (std::size_t i = 0; i < points; ++i) {
    const auto at = static_cast<float>(i);
    for (const float v : {10.0f * std::cos(at), 10.0f * std::sin(at), 0.1f * at, 0.37f})
      numbers.push_back(v);
    if (floats == 5) numbers.push_back(static_cast<float>(i % 32));
  }
  return numbers;
}

Result<PointCloud> read(const Bytes& bytes, std::size_t floats) {
  return read_sweep(ByteSource(ByteView(bytes)), floats);
}

TEST(Sweep, four_and_five_floats_a_point_are_told_apart_by_size_or_rings) {
  for (const std::size_t floats : {4, 5}) {
    for (const std::size_t points : {80, 41}) {  // 80: either would fit
      const std::vector<float> numbers = sweep(points, floats);
      const Result<PointCloud> cloud = read(bytes_of(numbers), 0);
      ASSERT_TRUE(cloud) << cloud.error().message;
      ASSERT_EQ(cloud->size(), points);
      EXPECT_EQ(cloud->world(7).y, numbers[7 * floats + 1]);
      ASSERT_EQ(cloud->scalars.size(), floats - 3);
      EXPECT_EQ(cloud->scalars.back().name, floats == 4 ? "intensity" : "ring");
      EXPECT_EQ(cloud->scalars.back().values[7], floats == 4 ? 0.37f : 7.0f);
    }
  }
}

TEST(Sweep, a_size_that_does_not_fit_is_an_error) {
  Bytes bytes = bytes_of(sweep(10, 4));
  EXPECT_THAT(read(bytes, 5)->size(), 8u);
  bytes.pop_back();
  EXPECT_THAT(read(bytes, 0).error().message,
              HasSubstr("159 bytes, which is no number of points of 4 floats"));
  EXPECT_THAT(read(bytes, 5).error().message, HasSubstr("nuScenes"));
}

TEST(Sweep, other_files_are_refused) {
  const Bytes text(1600, 'a');
  EXPECT_THAT(read(text, 0).error().message, HasSubstr("is no sweep"));
  const Bytes none = bytes_of(std::vector<float>(400, std::numeric_limits<float>::quiet_NaN()));
  EXPECT_THAT(read(none, 0).error().message, HasSubstr("is no sweep"));
}

}  // namespace
}  // namespace pointreel::sweep_test
