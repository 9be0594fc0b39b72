#include "common/base/backoff.h"

#include <gtest/gtest.h>

namespace pointreel::backoff_test {
namespace {

using namespace std::chrono_literals;

TEST(Backoff, doubles_after_each_failure_up_to_its_limit) {
  Backoff<std::chrono::milliseconds> backoff(100ms, 500ms);
  for (const auto expected : {100ms, 200ms, 400ms, 500ms, 500ms}) {
    EXPECT_EQ(backoff.wait(), expected);
    backoff.failed();
  }
}

TEST(Backoff, begins_again_after_a_success) {
  Backoff<double> seconds(1.0, 32.0);
  for (int i = 0; i < 3; ++i) seconds.failed();
  EXPECT_EQ(seconds.wait(), 8.0);
  seconds.succeeded();
  EXPECT_EQ(seconds.wait(), 1.0);
}

TEST(Backoff, is_shortened_at_random_but_by_no_more_than_a_third) {
  std::minstd_rand random(1);
  for (int i = 0; i < 100; ++i) {
    const auto wait = jittered(1s, random);
    EXPECT_GE(wait, 700ms);
    EXPECT_LE(wait, 1s);
  }
}

}  // namespace
}  // namespace pointreel::backoff_test
