#pragma once

#include <chrono>
#include <cstddef>

namespace pointreel {

/// By when more must have come of something that arrives in pieces, so that no peer holds anybody
/// up by sending next to nothing: all of it must come at a least rate on average.
class Pace {
 public:
  using Clock = std::chrono::steady_clock;
  /// How long it may take in addition, because every link may stop for a moment.
  static constexpr std::chrono::seconds kPatience{5};

  /// `least_rate` is in bytes per second; 0: none.
  explicit Pace(double least_rate) : least_rate_(least_rate) {}

  /// A piece of so many bytes has come. It may be empty.
  void came(std::size_t bytes, Clock::time_point now) {
    if (!under_way_) began_ = now;
    under_way_ = true;
    size_ += bytes;
  }
  /// It is complete, or nobody waits for it any more.
  void ended() {
    under_way_ = false;
    size_ = 0;
  }

  std::size_t size() const { return size_; }          ///< that came
  Clock::time_point began() const { return began_; }  ///< when its first piece came
  /// When it is too slow, unless more comes before; the end of time if nothing is under way.
  Clock::time_point due() const {
    if (!under_way_ || !(least_rate_ > 0)) return Clock::time_point::max();
    return began_ + kPatience +
           std::chrono::duration_cast<Clock::duration>(
               std::chrono::duration<double>(static_cast<double>(size_) / least_rate_));
  }

 private:
  double least_rate_;
  Clock::time_point began_{};
  bool under_way_ = false;
  std::size_t size_ = 0;
};

}  // namespace pointreel
