#include "common/base/stop_signal.h"

#include <ctime>

namespace pointreel {

StopSignal::StopSignal() {
  sigemptyset(&signals_);
  sigaddset(&signals_, SIGINT);
  sigaddset(&signals_, SIGTERM);
  pthread_sigmask(SIG_BLOCK, &signals_, &before_);
  struct sigaction usual{};
  usual.sa_handler = SIG_DFL;
  sigaction(SIGINT, &usual, &interrupt_before_);
  sigaction(SIGTERM, &usual, &terminate_before_);
  waiter_ = std::jthread([this](const std::stop_token& ended) {
    const timespec pause{0, 50'000'000};
    while (!ended.stop_requested()) {
      if (sigtimedwait(&signals_, nullptr, &pause) < 0) continue;
      source_.request_stop();
      // From here on this thread, and so the process, takes the signals' default action.
      pthread_sigmask(SIG_UNBLOCK, &signals_, nullptr);
      while (!ended.stop_requested()) nanosleep(&pause, nullptr);
    }
  });
}

StopSignal::~StopSignal() {
  waiter_.request_stop();
  waiter_.join();
  sigaction(SIGINT, &interrupt_before_, nullptr);
  sigaction(SIGTERM, &terminate_before_, nullptr);
  pthread_sigmask(SIG_SETMASK, &before_, nullptr);
}

}  // namespace pointreel
