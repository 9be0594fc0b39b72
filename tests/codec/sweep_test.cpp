#include "codec/files/sweep.h"

#include <cmath>
#include <cstring>
#include <functional>
#include <limits>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace pointreel::sweep_test {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::SizeIs;

Bytes bytes_of(const std::vector<float>& numbers) {
  Bytes bytes(numbers.size() * sizeof(float));
  std::memcpy(bytes.data(), numbers.data(), bytes.size());
  return bytes;
}

/// Points on a ring, as a scanner sees them, with what `more` adds to each.
std::vector<float> sweep(std::size_t points, const std::function<std::vector<float>(float)>& more) {
  std::vector<float> numbers;
  for (std::size_t i = 0; i < points; ++i) {
    const auto at = static_cast<float>(i);
    for (const float v : {10.0f * std::cos(at), 10.0f * std::sin(at), 0.1f * at})
      numbers.push_back(v);
    for (const float v : more(at)) numbers.push_back(v);
  }
  return numbers;
}

std::vector<float> kitti(std::size_t points) {
  return sweep(points, [](float) { return std::vector{0.37f}; });
}
std::vector<float> with_rings(std::size_t points) {
  return sweep(points, [](float i) { return std::vector{0.37f, std::fmod(i, 32.0f)}; });
}
std::vector<float> with_times(std::size_t points) {
  return sweep(points, [](float i) { return std::vector{0.37f, 1e-4f * i}; });
}

Result<PointCloud> read(const Bytes& bytes, std::vector<std::string> columns = {}) {
  ReadNotes notes;
  return read_sweep(ByteSource(ByteView(bytes)), {std::move(columns), 0.0}, notes);
}

std::vector<std::string> guess(const std::vector<Bytes>& files) {
  std::vector<std::uint64_t> sizes;
  for (const Bytes& file : files) sizes.push_back(file.size());
  const std::vector<ByteView> views(files.begin(), files.end());
  return guess_sweep_columns(sizes, views);
}

TEST(Sweep, the_number_of_floats_is_told_by_the_numbers_where_several_divide_the_size) {
  for (const std::size_t points : {80, 840, 41}) {
    EXPECT_THAT(guess({bytes_of(kitti(points))}), ElementsAre("x", "y", "z", "intensity"));
    EXPECT_THAT(guess({bytes_of(with_rings(points))}),
                ElementsAre("x", "y", "z", "intensity", "ring"));
    EXPECT_THAT(guess({bytes_of(with_times(points))}),
                ElementsAre("x", "y", "z", "intensity", "time"));
    const auto three = sweep(points, [](float) { return std::vector<float>(); });
    EXPECT_THAT(guess({bytes_of(three)}), ElementsAre("x", "y", "z"));
    const auto zero = sweep(points, [](float) { return std::vector{0.37f, 0.0f}; });
    EXPECT_THAT(guess({bytes_of(zero)}), ElementsAre("x", "y", "z", "intensity", "_"));
    const auto colors = sweep(points, [](float i) {
      return std::vector{std::fmod(7.0f * i, 256.0f), 200.0f, std::fmod(i, 256.0f)};
    });
    EXPECT_THAT(guess({bytes_of(colors)}), ElementsAre("x", "y", "z", "r", "g", "b"));
  }
}

TEST(Sweep, the_number_of_floats_does_not_depend_on_the_order_of_points) {
  std::mt19937 random(1);
  std::uniform_real_distribution<float> place(-30.0f, 30.0f), share(0.0f, 1.0f);
  for (const std::size_t floats : {4, 5}) {
    std::vector<float> numbers;
    for (int i = 0; i < 8400; ++i) {
      for (const float v : {place(random), place(random), 0.1f * place(random), share(random)})
        numbers.push_back(v);
      if (floats == 5) numbers.push_back(std::floor(32.0f * share(random)));
    }
    EXPECT_EQ(guess({bytes_of(numbers)}).size(), floats);
  }
}

TEST(Sweep, all_files_of_a_sequence_decide_together) {
  std::vector<Bytes> files;
  for (std::size_t points = 400; points < 405; ++points)
    files.push_back(bytes_of(with_times(points)));
  EXPECT_THAT(guess(files), ElementsAre("x", "y", "z", "intensity", "time"));
  // One that was cut off changes nothing.
  files[2].pop_back();
  EXPECT_THAT(guess(files), ElementsAre("x", "y", "z", "intensity", "time"));
}

TEST(Sweep, columns_that_were_not_named_become_scalar_fields) {
  const std::vector<float> numbers = with_rings(80);
  const Result<PointCloud> cloud = read(bytes_of(numbers));
  ASSERT_TRUE(cloud) << cloud.error().message;
  ASSERT_EQ(cloud->size(), 80u);
  EXPECT_EQ(cloud->world(7).y, numbers[7 * 5 + 1]);
  ASSERT_EQ(cloud->scalars.size(), 2u);
  EXPECT_EQ(cloud->scalars[1].name, "ring");
  EXPECT_EQ(cloud->scalars[1].values[7], 7.0f);
}

TEST(Sweep, given_columns_hold) {
  const Result<PointCloud> cloud =
      read(bytes_of({1, 2, 3, 0, 128, 255, 4, 5, 6, 0, 0, 51}), {"x", "y", "z", "r", "_", "b"});
  ASSERT_TRUE(cloud) << cloud.error().message;
  EXPECT_THAT(cloud->scalars, SizeIs(2));
  const Result<PointCloud> colored =
      read(bytes_of({1, 2, 3, 0, 128, 255, 4, 5, 6, 0, 0, 51}), {"z", "y", "x", "r", "g", "b"});
  ASSERT_TRUE(colored) << colored.error().message;
  EXPECT_EQ(colored->world(0), glm::dvec3(3, 2, 1));
  EXPECT_THAT(colored->colors,
              ElementsAre(glm::u16vec3(0, 128 * 257, 65535), glm::u16vec3(0, 0, 51 * 257)));
}

TEST(Sweep, a_size_that_does_not_fit_is_an_error) {
  Bytes bytes = bytes_of(kitti(10));
  bytes.pop_back();
  EXPECT_THAT(read(bytes).error().message, HasSubstr("is not a laser scan"));
  EXPECT_THAT(read(bytes, nuscenes_columns()).error().message,
              HasSubstr("159 bytes, which is not a whole number of points of 5 floats"));
}

TEST(Sweep, other_files_are_refused) {
  const Bytes text(1600, 'a');
  const Bytes none = bytes_of(std::vector<float>(400, std::numeric_limits<float>::quiet_NaN()));
  for (const Bytes& bytes : {text, none}) {
    EXPECT_THAT(read(bytes).error().message, HasSubstr("is not a laser scan"));
    EXPECT_THAT(read(bytes, nuscenes_columns()).error().message,
                HasSubstr("impossible coordinates"));
  }
}

}  // namespace
}  // namespace pointreel::sweep_test
