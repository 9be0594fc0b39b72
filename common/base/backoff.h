#pragma once

#include <algorithm>
#include <chrono>
#include <random>

namespace pointreel {

/// How long to wait before another attempt: longer after each failure. `Time` is a duration or a
/// number of anything that passes, such as seconds or frames.
template <class Time>
class Backoff {
 public:
  /// 0 < first <= most.
  constexpr Backoff(Time first, Time most) : first_(first), most_(most), wait_(first) {}

  constexpr Time wait() const { return wait_; }
  /// The attempt failed: the next wait is twice as long, but no longer than `most`.
  constexpr void failed() { wait_ = std::min<Time>(2 * wait_, most_); }
  /// It succeeded: the next wait is `first` again.
  constexpr void succeeded() { wait_ = first_; }

 private:
  Time first_, most_, wait_;
};

/// 70 to 100 percent of the wait, at random, so that those who lost the same server do not all come
/// back at the same moment.
template <class Random>
std::chrono::steady_clock::duration jittered(std::chrono::steady_clock::duration wait,
                                             Random& random) {
  const double share = std::uniform_real_distribution(0.7, 1.0)(random);
  return std::chrono::duration_cast<std::chrono::steady_clock::duration>(share * wait);
}

}  // namespace pointreel
