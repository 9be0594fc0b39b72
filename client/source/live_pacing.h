#pragma once

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>

namespace pointreel {

/// When to show frames that come a segment at a time, so that they are shown as evenly as they were
/// captured: each is shown as long after its capture as the slowest of the last few segments took
/// to come. The publisher's clock need not agree with ours. If it jumps, what was known of it is
/// forgotten.
class LivePacing {
 public:
  using Time = std::chrono::steady_clock::time_point;

  /// A segment whose first frame was captured at `capture_us` has come.
  void arrived(std::uint64_t capture_us, Time now) {
    const Time::duration offset = now - on_their_clock(capture_us);
    if (!offsets_.empty() && std::chrono::abs(offset - offsets_.back()) > kJump) offsets_.clear();
    offsets_.push_back(offset);
    if (offsets_.size() > kMemory) offsets_.pop_front();
  }

  /// When to show a frame. Call it only after the first arrival.
  Time due(std::uint64_t capture_us) const {
    return on_their_clock(capture_us) + *std::max_element(offsets_.begin(), offsets_.end());
  }

  /// There is another publisher, whose clock differs.
  void reset() { offsets_.clear(); }

 private:
  static constexpr std::size_t kMemory = 16;
  /// Segments that come later than usual by as much as this are not shown at all.
  static constexpr std::chrono::seconds kJump{10};

  static Time on_their_clock(std::uint64_t capture_us) {
    return Time(std::chrono::microseconds(static_cast<std::int64_t>(capture_us)));
  }

  std::deque<Time::duration> offsets_;
};

}  // namespace pointreel
