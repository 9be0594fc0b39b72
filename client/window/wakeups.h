#pragma once

#include <atomic>
#include <chrono>

namespace pointreel {

/// Lets the main thread sleep until the window has events, another thread wakes it, or it is time.
class Wakeups {
 public:
  /// May be called by any thread while GLFW is initialised.
  void wake();
  /// Handles the events of all windows, after waiting for one until `until` at most.
  void wait(std::chrono::steady_clock::time_point until);

 private:
  std::atomic<bool> posted_{false};  ///< since the last wait; one event is enough
};

}  // namespace pointreel
