#pragma once

#include <algorithm>
#include <chrono>
#include <cstddef>

namespace pointreel {

/// Holds a sender to a rate. The bytes of one second may come at once.
class RateLimit {
 public:
  using Clock = std::chrono::steady_clock;

  /// 0: unlimited.
  explicit RateLimit(double bytes_per_second) : rate_(bytes_per_second) {}

  void add(std::size_t bytes) {
    if (rate_ <= 0) return;
    paid_ = std::max(paid_, Clock::now() - std::chrono::seconds(1)) +
            std::chrono::duration_cast<Clock::duration>(
                std::chrono::duration<double>(static_cast<double>(bytes) / rate_));
  }
  /// The time by which all bytes received so far would have come at the allowed rate.
  Clock::time_point paid() const { return paid_; }
  /// For how long the sender should not be read from. May be negative.
  Clock::duration ahead() const { return paid_ - Clock::now(); }
  bool is_exceeded() const { return ahead() > std::chrono::seconds(5); }
  double rate() const { return rate_; }

 private:
  double rate_;
  Clock::time_point paid_ = Clock::now() - std::chrono::seconds(1);
};

}  // namespace pointreel
