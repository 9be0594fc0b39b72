#pragma once

#include <chrono>
#include <mutex>

namespace pointreel {

/// Time at the pace of a sound card, whose clock differs from the machine's by up to a few parts in
/// a thousand. Reels are played by this time, so that their pictures stay with their sound. It
/// never jumps and never goes back. Without a sound card it is the machine's time. All functions
/// may be called from any thread.
class PacedTime {
 public:
  using TimePoint = std::chrono::steady_clock::time_point;

  /// Paced time at `now`, a time of the machine.
  TimePoint at(TimePoint now) const;

  /// Lets it approach `target`, which is what a sound card says that it should be at `now`, as an
  /// error of e seconds that is corrected by e / kCorrection in each second. What it takes in one
  /// step does not matter: a sound card's answers are a few milliseconds too early or late.
  void follow(TimePoint target, TimePoint now);
  /// Goes on as the machine's time does.
  void let_go(TimePoint now);

 private:
  static constexpr double kCorrection = 2.0;  ///< seconds
  static constexpr double kMostOff = 0.02;    ///< the largest difference of the two paces

  TimePoint value(TimePoint now) const;
  void set_pace(double pace, TimePoint now);

  mutable std::mutex mutex_;
  TimePoint base_{}, base_now_{};  ///< paced, and the machine's
  double pace_ = 1.0;
  mutable TimePoint last_{};  ///< that was given to anyone
};

}  // namespace pointreel
