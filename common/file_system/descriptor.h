#pragma once

#include <cerrno>
#include <stop_token>
#include <string>
#include <system_error>

#include <poll.h>

namespace pointreel {

/// The longest time that a wait for a descriptor continues after it was stopped.
inline constexpr int kPollMs = 50;

/// Waits until a descriptor can be read. False if `stopped()` says so, or if polling failed.
template <class Stopped>
bool wait_readable(int descriptor, const Stopped& stopped) {
  while (!stopped()) {
    pollfd waiting{descriptor, POLLIN, 0};
    const int ready = ::poll(&waiting, 1, kPollMs);
    if (ready > 0) return true;
    if (ready < 0 && errno != EINTR) return false;
  }
  return false;
}

inline bool wait_readable(int descriptor, const std::stop_token& stop) {
  return wait_readable(descriptor, [&stop] { return stop.stop_requested(); });
}

/// The system's words for errno.
inline std::string errno_message() { return std::generic_category().message(errno); }

}  // namespace pointreel
