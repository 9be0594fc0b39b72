#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <map>
#include <mutex>

namespace pointreel {

/// How often each address may ask. A token bucket for each, that holds a second's worth. Any thread
/// may call it.
class RateLimiter {
 public:
  using Clock = std::chrono::steady_clock;
  using Network = std::array<std::uint8_t, 16>;

  /// `rate` requests a second of each; 0: any number.
  explicit RateLimiter(double rate) : rate_(rate) {}

  /// False: too fast, come again in a second.
  bool allow(const Network& network, Clock::time_point now);
  bool limits() const { return rate_ > 0; }
  /// Addresses that are remembered: those that have asked lately, and no more than kMost.
  std::size_t size() const;

  static constexpr std::size_t kMost = 65'536;

 private:
  double rate_;
  mutable std::mutex mutex_;
  /// When the bucket is full again.
  std::map<Network, Clock::time_point> full_at_;
  Clock::time_point next_look_{};  ///< for those to forget, no sooner: looking takes long
};

}  // namespace pointreel
