#include "client/record/frame_rate.h"

#include <cmath>
#include <vector>

#include <gtest/gtest.h>

namespace pointreel::frame_rate_test {
namespace {

std::vector<std::uint64_t> times(double fps, int count, double start_us = 0.0) {
  std::vector<std::uint64_t> all;
  for (int i = 0; i < count; ++i)
    all.push_back(static_cast<std::uint64_t>(std::llround(start_us + 1e6 * i / fps)));
  return all;
}

TEST(FrameRate, is_recovered_exactly_from_rounded_times) {
  for (const std::uint64_t fps : {1u, 5u, 10u, 15u, 24u, 25u, 30u, 50u, 60u, 90u, 120u, 240u})
    for (const int count : {2, 3, 10, 1000})
      EXPECT_EQ(exact_rate(times(static_cast<double>(fps), count)), (FrameRate{fps, 1}))
          << fps << " " << count;
  EXPECT_EQ(exact_rate(times(12.5, 100)), (FrameRate{25, 2}));
  EXPECT_EQ(exact_rate(times(1.0 / 3.0, 5)), (FrameRate{1, 3}));
  EXPECT_EQ(exact_rate(times(29.97, 100'000)), (FrameRate{2997, 100}));
}

TEST(FrameRate, prefers_rates_of_television_if_they_fit) {
  for (const std::uint64_t frames : {24'000u, 30'000u, 60'000u, 120'000u})
    for (const int count : {2, 10, 100'000})
      EXPECT_EQ(exact_rate(times(static_cast<double>(frames) / 1001.0, count)),
                (FrameRate{frames, 1001}));
}

TEST(FrameRate, does_not_depend_on_the_first_time) {
  EXPECT_EQ(exact_rate(times(30.0, 1000, 123'456.7)), (FrameRate{30, 1}));
}

TEST(FrameRate, is_absent_if_one_frame_lasts_longer_than_the_others) {
  std::vector<std::uint64_t> uneven = times(30.0, 100);
  EXPECT_TRUE(exact_rate(uneven));
  uneven[50] += 3;
  EXPECT_FALSE(exact_rate(uneven));
  EXPECT_FALSE(exact_rate(std::vector<std::uint64_t>{0, 100, 150}));
}

TEST(FrameRate, is_absent_for_fewer_than_two_times_or_equal_times) {
  EXPECT_FALSE(exact_rate({}));
  EXPECT_FALSE(exact_rate(std::vector<std::uint64_t>{5}));
  EXPECT_FALSE(exact_rate(std::vector<std::uint64_t>{5, 5}));
  EXPECT_FALSE(exact_rate(std::vector<std::uint64_t>{5, 6}));
}

}  // namespace
}  // namespace pointreel::frame_rate_test
