#pragma once

#include <chrono>
#include <thread>

namespace pointreel {

/// Waits until `condition()` is true and returns whether it came to that within `timeout`. For what
/// no condition variable announces, such as another process, a peer across a socket, or a thread of
/// the code under test. The only place in which a test sleeps while it waits for something.
template <class Condition>
bool wait_until(Condition&& condition, std::chrono::milliseconds timeout = std::chrono::seconds(60),
                std::chrono::milliseconds interval = std::chrono::milliseconds(1)) {
  const auto end = std::chrono::steady_clock::now() + timeout;
  while (!condition()) {
    if (std::chrono::steady_clock::now() >= end) return false;
    std::this_thread::sleep_for(interval);
  }
  return true;
}

/// Stands for work that takes this long in a fake: nothing is waited for.
template <class Duration>
void work_for(Duration time) {
  std::this_thread::sleep_for(time);
}

/// How long to look for something that must not happen, where no later event would prove that it
/// did not: EXPECT_FALSE(wait_until(it_happened, kMoment)). A slow machine may miss a fault this
/// way, but it never reports one that is not there.
inline constexpr std::chrono::milliseconds kMoment{20};

}  // namespace pointreel
