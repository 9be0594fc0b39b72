#include "client/playback/statistics.h"

#include <gtest/gtest.h>

namespace pointreel::statistics_test {
namespace {

TEST(TimeSamples, are_zero_if_nothing_was_measured) {
  EXPECT_EQ(TimeSamples().summary().median, 0.0);
  EXPECT_EQ(TimeSamples().summary().max, 0.0);
}

TEST(TimeSamples, give_percentiles_by_nearest_rank_in_any_order) {
  TimeSamples samples;
  for (int i = 0; i < 100; ++i) samples.add(1 + (i * 37) % 100);
  EXPECT_EQ(samples.summary().median, 50.0);
  EXPECT_EQ(samples.summary().p95, 95.0);
  EXPECT_EQ(samples.summary().max, 100.0);
}

TEST(TimeSamples, summarise_a_single_sample_as_itself) {
  TimeSamples samples;
  samples.add(3.5);
  EXPECT_EQ(samples.summary().median, 3.5);
  EXPECT_EQ(samples.summary().p95, 3.5);
}

TEST(TimeSamples, forget_the_oldest_samples_but_not_the_maximum) {
  TimeSamples samples;
  samples.add(1000.0);
  for (std::size_t i = 0; i < TimeSamples::kMaxSamples; ++i) samples.add(2.0);
  EXPECT_EQ(samples.summary().p95, 2.0);
  EXPECT_EQ(samples.summary().max, 1000.0);
}

}  // namespace
}  // namespace pointreel::statistics_test
