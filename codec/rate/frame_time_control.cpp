#include "codec/rate/frame_time_control.h"

#include <algorithm>
#include <utility>

namespace pointreel {
namespace {

constexpr double kBehind = 0.5;  ///< the depth is lowered when frames are this many budgets behind
constexpr double kInTime = 0.8;  ///< the share of the budget that a finer frame may take
constexpr double kGrowth = 2.0;  ///< the factor by which a level increases the time

}  // namespace

void FrameTimeControl::told(int depth, double ms) {
  late_ += ms > budget_ms_ ? 1 : 0;
  if (depth > depth_) return;
  behind_ms_ = std::max(0.0, behind_ms_ + ms - budget_ms_);
  if (good_ && ms <= kInTime * budget_ms_) ++*good_;
  const double at_least = std::min(ms, std::exchange(before_ms_, ms));
  if (at_least > budget_ms_) {
    calm_ = 0;
    if (behind_ms_ >= kBehind * budget_ms_) lower(depth, at_least);
  } else {
    maybe_raise(depth, at_least);
  }
}

void FrameTimeControl::lower(int depth, double ms) {
  const bool too_much = good_ && *good_ < kLeastPatience;
  // The level below the additional one was in time.
  const int coarsest = good_ == 0 ? std::max(coarsest_, depth - 1) : coarsest_;
  while (depth > coarsest && ms > budget_ms_) {
    --depth;
    ms /= kGrowth;
  }
  if (too_much) {
    patience_.failed();
  } else {
    patience_.succeeded();
  }
  depth_ = std::min(depth, finest_);
  before_ms_ = kUnknown;
  good_.reset();
}

void FrameTimeControl::maybe_raise(int depth, double ms) {
  // A frame with fewer levels than allowed does not show how long an additional one would take.
  if (depth != depth_ || depth_ == finest_ || ms * kGrowth > kInTime * budget_ms_) {
    calm_ = 0;
  } else if (behind_ms_ == 0.0 && ++calm_ >= patience_.wait()) {
    ++depth_;
    calm_ = 0;
    good_ = 0;
    before_ms_ = kUnknown;
  }
}

}  // namespace pointreel
