#pragma once

#include <chrono>
#include <cstddef>

namespace pointreel {

/// By when something must have come from a publisher, so that nobody holds a place by sending next
/// to nothing: its hello, and then each message that is under way, at a least rate on average.
class MessagePace {
 public:
  using Clock = std::chrono::steady_clock;
  /// How long a message may take in addition, because every link may stop for a moment.
  static constexpr std::chrono::seconds kPatience{5};

  /// `least_rate` is in bytes per second; 0: none.
  MessagePace(double least_rate, Clock::time_point hello_due)
      : least_rate_(least_rate), hello_due_(hello_due) {}

  void greeted() { hello_due_ = Clock::time_point::max(); }
  bool awaits_hello() const { return hello_due_ != Clock::time_point::max(); }

  /// A piece of a message with so many bytes has come. It may be empty.
  void came(std::size_t bytes, Clock::time_point now) {
    if (!under_way_) began_ = now;
    under_way_ = true;
    size_ += bytes;
  }
  /// The message is complete.
  void ended() {
    under_way_ = false;
    size_ = 0;
  }

  /// When the publisher is too slow, unless more comes before; the end of time if nothing is due.
  Clock::time_point due() const {
    Clock::time_point message = Clock::time_point::max();
    if (under_way_ && least_rate_ > 0) {
      message = began_ + kPatience +
                std::chrono::duration_cast<Clock::duration>(
                    std::chrono::duration<double>(static_cast<double>(size_) / least_rate_));
    }
    return message < hello_due_ ? message : hello_due_;
  }

 private:
  double least_rate_;
  Clock::time_point hello_due_, began_{};
  bool under_way_ = false;
  std::size_t size_ = 0;
};

}  // namespace pointreel
