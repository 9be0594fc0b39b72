#pragma once

#include <stop_token>
#include <thread>

#include <signal.h>

namespace pointreel {

/// Turns the first SIGINT or SIGTERM into a stop request while it lives; a second one ends the
/// process, even one that a shell has started in the background, with SIGINT ignored. Make it
/// before any thread is started that should not be killed by the first: threads inherit that the
/// signals are blocked.
class StopSignal {
 public:
  StopSignal();
  ~StopSignal();
  StopSignal(const StopSignal&) = delete;
  StopSignal& operator=(const StopSignal&) = delete;

  std::stop_token token() const { return source_.get_token(); }

 private:
  std::stop_source source_;
  sigset_t signals_{}, before_{};
  struct sigaction interrupt_before_{}, terminate_before_{};
  std::thread waiter_;
};

}  // namespace pointreel
