#pragma once

#include <stop_token>
#include <thread>

#include <signal.h>

namespace pointreel {

/// During its lifetime, turns the first SIGINT or SIGTERM into a stop request; the next one, unless
/// it comes at once, as `timeout` sends two, ends the process, even if a shell started it in the
/// background with SIGINT ignored. Construct it before starting threads: they inherit the blocked
/// signals, and a thread without them would be killed by the first signal.
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
