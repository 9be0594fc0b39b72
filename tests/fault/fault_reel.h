#pragma once

#include <gtest/gtest.h>

#include "tests/fault/served_reel.h"
#include "tests/fault/watcher.h"
#include "tests/temporary_folder.h"

namespace pointreel {

/// The reel of the ball and its truth, made once for all tests.
class FaultReel {
 public:
  static const FaultReel& get() {
    static const FaultReel reel;
    return reel;
  }
  std::filesystem::path path() const { return folder_ / "ball"; }
  const Truth& truth() const { return truth_; }
  double bits_per_second() const { return bits_per_second_; }

 private:
  FaultReel() {
    const auto made = make_ball_reel(path());
    EXPECT_TRUE(made) << made.error().message;
    bits_per_second_ = made.value_or(0.0);
    truth_ = truth_of(path()).value_or(Truth{});
    EXPECT_FALSE(truth_.empty());
  }
  TemporaryFolder folder_;
  Truth truth_;
  double bits_per_second_ = 0.0;
};

}  // namespace pointreel
