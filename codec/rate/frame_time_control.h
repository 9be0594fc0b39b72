#pragma once

#include <cstdint>
#include <limits>
#include <optional>

#include "codec/package/coarsening.h"
#include "common/base/backoff.h"
#include "pointreel/octree.h"

namespace pointreel {

/// Lowers the depth so that encoding a frame does not take longer than a budget. A value without a
/// clock of its own: it is told how long frames took.
///
/// Time above the budget adds up, and time below it makes up for that. Once frames are half a
/// budget behind, the next ones are as much coarser as necessary to be in time; but where a depth
/// has been in time, a single late frame is the machine's fault, which other programs share. The
/// depth rises again by one level at a time, after a number of frames that would have been in time
/// with a fifth to spare even with the additional level. That number doubles each time the
/// additional level turns out to be too much, which it is not if it was in time for a while: then
/// other programs had the processor. A level is assumed to double the time, which is less than it
/// does on most scenes: so no level is given up for good, and thanks to the growing number of
/// frames, levels that are too much are rarely tried.
class FrameTimeControl {
 public:
  /// `budget_ms` is above 0. `finest` is the depth at the start, which is never exceeded, and
  /// `coarsest` the depth below which it is never lowered, however long frames take.
  explicit FrameTimeControl(double budget_ms, int finest = kMaxDepth, int coarsest = kCoarsestDepth)
      : budget_ms_(budget_ms), finest_(finest), coarsest_(coarsest), depth_(finest) {}

  /// The greatest depth that the next frame may have.
  int depth() const { return depth_; }

  /// A frame of this depth, which may be less than was allowed, took this long to encode. A frame
  /// that was begun before the depth was lowered counts as late, but has no other effect.
  void told(int depth, double ms);

  /// The number of frames that took longer than the budget.
  std::uint64_t late() const { return late_; }
  /// By how much frames are behind at present.
  double behind_ms() const { return behind_ms_; }

 private:
  void lower(int depth, double ms);
  void maybe_raise(int depth, double ms);

  static constexpr int kLeastPatience = 8, kMaxPatience = 512;  ///< frames
  static constexpr double kUnknown = std::numeric_limits<double>::infinity();

  double budget_ms_;
  int finest_, coarsest_, depth_;
  double behind_ms_ = 0.0;
  /// What the frame before took, if it had the present depth; otherwise too long.
  double before_ms_ = kUnknown;
  std::uint64_t late_ = 0;
  /// How many frames must be in time before the depth rises.
  Backoff<int> patience_{kLeastPatience, kMaxPatience};
  /// How many frames would have been in time with another level.
  int calm_ = 0;
  /// How many frames were in time, with a fifth to spare, since the depth last rose; none after it
  /// fell.
  std::optional<int> good_;
};

}  // namespace pointreel
