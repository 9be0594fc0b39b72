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
  since_raise_ = std::min(since_raise_ + 1, kMaxPatience);
  const double at_least = std::min(ms, std::exchange(before_ms_, ms));
  if (ms > budget_ms_) {
    calm_ = 0;
    if (behind_ms_ >= kBehind * budget_ms_ && at_least > budget_ms_) lower(depth, at_least);
  } else {
    maybe_raise(depth, ms);
  }
}

void FrameTimeControl::lower(int depth, double ms) {
  while (depth > coarsest_ && ms > budget_ms_) {
    --depth;
    ms /= kGrowth;
  }
  if (since_raise_ < kMaxPatience) {
    patience_.failed();  // the last additional level was soon too much
  } else {
    patience_.succeeded();
  }
  depth_ = std::min(depth, finest_);
  before_ms_ = kUnknown;
}

void FrameTimeControl::maybe_raise(int depth, double ms) {
  const bool bounded = depth == depth_ && depth_ < finest_;
  const bool would_be_in_time = ms * kGrowth <= kInTime * budget_ms_;
  // A frame with fewer levels than allowed does not show how long an additional one would take.
  calm_ = bounded && would_be_in_time && behind_ms_ == 0.0 ? calm_ + 1 : 0;
  if (calm_ < patience_.wait()) return;
  ++depth_;
  calm_ = 0;
  since_raise_ = 0;
  before_ms_ = kUnknown;
}

}  // namespace pointreel
