#pragma once

#include <cerrno>
#include <stop_token>
#include <string>
#include <system_error>
#include <utility>

#include <poll.h>
#include <unistd.h>

namespace pointreel {

/// An open file, closed with its owner. -1: none.
class Descriptor {
 public:
  explicit Descriptor(int file = -1) : file_(file) {}
  Descriptor(Descriptor&& other) noexcept : file_(std::exchange(other.file_, -1)) {}
  Descriptor& operator=(Descriptor&& other) noexcept {
    std::swap(file_, other.file_);
    return *this;
  }
  ~Descriptor() { close(); }
  int get() const { return file_; }
  void close() {
    if (file_ >= 0) ::close(std::exchange(file_, -1));
  }

 private:
  int file_;
};

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
