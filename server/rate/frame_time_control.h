#pragma once

#include <cstdint>

#include "common/octree/morton.h"
#include "pointreel/octree.h"
#include "server/rate/coarsening.h"

namespace pointreel {

/// Keeps encoding within a time for each frame, by depth: a value without a clock of its own, which
/// is told what frames took.
///
/// Time that is over the budget adds up, time that is under it makes up for it. Once frames are
/// half a budget behind, the next ones are as much coarser as it takes to be in time. Finer again
/// goes one level at a time, after a while in which that would have been in time with a fifth to
/// spare; a while that doubles each time that it proves too short. A level is taken to double the
/// time: less than it does on most scenes, so that no level is given away for good, and the growing
/// while sees to it that what fails is seldom tried.
class FrameTimeControl {
 public:
  /// Above 0; the depth to begin with, which is never exceeded; and the least depth, which is not
  /// lowered whatever frames take.
  explicit FrameTimeControl(double budget_ms, int finest = kMaxDepth, int coarsest = kCoarsestDepth)
      : budget_ms_(budget_ms), finest_(finest), coarsest_(coarsest), depth_(finest) {}

  /// The most that the next frame may be divided.
  int depth() const { return depth_; }

  /// A frame was encoded `depth` levels deep, fewer where it was not worth more, in so many
  /// milliseconds. One that began before the depth was lowered counts as late and no more.
  void told(int depth, double ms);

  /// Frames that took longer than the budget; how far behind frames are now.
  std::uint64_t late() const { return late_; }
  double behind_ms() const { return behind_ms_; }

 private:
  void lower(int depth, double ms);
  void maybe_raise(int depth, double ms);

  static constexpr int kFirstPatience = 8, kMostPatience = 512;

  double budget_ms_;
  int finest_, coarsest_, depth_;
  double behind_ms_ = 0.0;
  std::uint64_t late_ = 0;
  int calm_ = 0, patience_ = kFirstPatience;  ///< frames
  int since_raise_ = kMostPatience;
};

}  // namespace pointreel
