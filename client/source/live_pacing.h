#pragma once

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>

namespace pointreel {

/// When to show frames that come by the segment, so that they are shown as evenly as they were
/// captured: so long after their capture as the slowest of the last few segments took to come. The
/// publisher's clock need not agree with ours.
class LivePacing {
 public:
  using Time = std::chrono::steady_clock::time_point;

  /// A segment whose first frame was captured at `capture_us` is here.
  void arrived(std::uint64_t capture_us, Time now) {
    offsets_.push_back(now - on_their_clock(capture_us));
    if (offsets_.size() > kMemory) offsets_.pop_front();
  }

  /// After the first arrival.
  Time due(std::uint64_t capture_us) const {
    return on_their_clock(capture_us) + *std::max_element(offsets_.begin(), offsets_.end());
  }

  /// Another publisher.
  void reset() { offsets_.clear(); }

 private:
  static constexpr std::size_t kMemory = 16;

  static Time on_their_clock(std::uint64_t capture_us) {
    return Time(std::chrono::microseconds(static_cast<std::int64_t>(capture_us)));
  }

  std::deque<Time::duration> offsets_;
};

}  // namespace pointreel
