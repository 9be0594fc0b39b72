#pragma once

#include <algorithm>

#include "common/base/pace.h"

namespace pointreel {

/// By when something must have come from a publisher: its hello, and then more of the message that
/// is under way.
class MessagePace {
 public:
  using Clock = Pace::Clock;

  /// `least_rate` is in bytes per second; 0: none.
  MessagePace(double least_rate, Clock::time_point hello_due)
      : message_(least_rate), hello_due_(hello_due) {}

  void greeted() { hello_due_ = Clock::time_point::max(); }
  bool awaits_hello() const { return hello_due_ != Clock::time_point::max(); }

  /// A piece of a message with so many bytes has come. It may be empty.
  void came(std::size_t bytes, Clock::time_point now) { message_.came(bytes, now); }
  /// The message is complete.
  void ended() { message_.ended(); }

  /// When the publisher is too slow, unless more comes before; the end of time if nothing is due.
  Clock::time_point due() const { return std::min(message_.due(), hello_due_); }

 private:
  Pace message_;
  Clock::time_point hello_due_;
};

}  // namespace pointreel
