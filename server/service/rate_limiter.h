#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <map>
#include <mutex>

namespace pointreel {

/// Limits how many requests per second each address may make. Each address has a token bucket that
/// holds the requests of one second. Any thread may call this.
class RateLimiter {
 public:
  using Clock = std::chrono::steady_clock;
  using Network = std::array<std::uint8_t, 16>;

  /// `rate` is in requests per second; 0: unlimited.
  explicit RateLimiter(double rate) : rate_(rate) {}

  /// False if the request comes too fast and should be repeated after a second.
  bool allow(const Network& network, Clock::time_point now);
  bool limits() const { return rate_ > 0; }
  /// The number of addresses in memory: those with recent requests, and no more than kMost.
  std::size_t size() const;

  static constexpr std::size_t kMost = 65'536;

 private:
  double rate_;
  mutable std::mutex mutex_;
  /// When the bucket of each address will be full again.
  std::map<Network, Clock::time_point> full_at_;
  Clock::time_point next_look_{};  ///< when to look again for addresses to forget; this takes long
};

}  // namespace pointreel
