#pragma once

#include <condition_variable>
#include <cstdint>
#include <mutex>

namespace pointreel {

/// Lets threads do something one after another, in the order of numbers that they hold: 0, 1, 2...
/// Each number must take its turn, or later ones wait for ever.
class OrderedTurns {
 public:
  /// Waits until all smaller numbers have had their turn, and calls `work`. What happens in a turn
  /// is seen by all later ones.
  template <class Work>
  void take(std::uint64_t number, const Work& work) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return next_ == number; });
    const End end{*this};
    work();
  }

 private:
  /// Ends a turn even if its work throws. The lock is held.
  struct End {
    OrderedTurns& turns;
    ~End() {
      ++turns.next_;
      turns.changed_.notify_all();
    }
  };

  std::mutex mutex_;
  std::condition_variable changed_;
  std::uint64_t next_ = 0;
};

}  // namespace pointreel
