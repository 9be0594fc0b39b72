#include "server/rate/frame_time_control.h"

#include <algorithm>

namespace pointreel {
namespace {

constexpr double kBehind = 0.5;  ///< budgets behind at which something is done
constexpr double kInTime = 0.8;  ///< share of the budget that finer frames may take
constexpr double kGrowth = 2.0;  ///< of the time with a level

}  // namespace

void FrameTimeControl::told(int depth, double ms) {
  late_ += ms > budget_ms_ ? 1 : 0;
  if (depth > depth_) return;
  behind_ms_ = std::max(0.0, behind_ms_ + ms - budget_ms_);
  since_raise_ = std::min(since_raise_ + 1, kMostPatience);
  if (ms > budget_ms_) {
    calm_ = 0;
    if (behind_ms_ >= kBehind * budget_ms_) lower(depth, ms);
  } else {
    maybe_raise(depth, ms);
  }
}

void FrameTimeControl::lower(int depth, double ms) {
  while (depth > coarsest_ && ms > budget_ms_) {
    --depth;
    ms /= kGrowth;
  }
  // A raise that did not last was made too soon.
  patience_ =
      since_raise_ < kMostPatience ? std::min(2 * patience_, kMostPatience) : kFirstPatience;
  depth_ = std::min(depth, finest_);
}

void FrameTimeControl::maybe_raise(int depth, double ms) {
  const bool bounded = depth == depth_ && depth_ < finest_;
  const bool would_be_in_time = ms * kGrowth <= kInTime * budget_ms_;
  // A frame that was not worth the levels it might have had says nothing of a level more.
  calm_ = bounded && would_be_in_time && behind_ms_ == 0.0 ? calm_ + 1 : 0;
  if (calm_ < patience_) return;
  ++depth_;
  calm_ = 0;
  since_raise_ = 0;
}

}  // namespace pointreel
