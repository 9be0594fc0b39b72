#include "common/process/stop_signal.h"

namespace pointreel {

// SIGRTMIN, sent by the destructor to the waiting thread alone, tells it to end. If the thread
// polled for that instead, every command would exit later by up to the interval of polling.
StopSignal::StopSignal() {
  sigemptyset(&signals_);
  sigaddset(&signals_, SIGINT);
  sigaddset(&signals_, SIGTERM);
  sigset_t ended, any = signals_;
  sigemptyset(&ended);
  sigaddset(&ended, SIGRTMIN);
  sigaddset(&any, SIGRTMIN);
  pthread_sigmask(SIG_BLOCK, &any, &before_);
  struct sigaction usual{};
  usual.sa_handler = SIG_DFL;
  sigaction(SIGINT, &usual, &interrupt_before_);
  sigaction(SIGTERM, &usual, &terminate_before_);
  waiter_ = std::thread([this, any, ended] {
    int signal = 0;
    sigwait(&any, &signal);
    if (signal == SIGRTMIN) return;
    source_.request_stop();
    const timespec at_once{0, 200'000'000};
    while ((signal = sigtimedwait(&any, nullptr, &at_once)) > 0)
      if (signal == SIGRTMIN) return;
    // From now on this thread receives the signals, whose default action ends the process.
    pthread_sigmask(SIG_UNBLOCK, &signals_, nullptr);
    sigwait(&ended, &signal);
  });
}

StopSignal::~StopSignal() {
  pthread_kill(waiter_.native_handle(), SIGRTMIN);
  waiter_.join();
  sigaction(SIGINT, &interrupt_before_, nullptr);
  sigaction(SIGTERM, &terminate_before_, nullptr);
  pthread_sigmask(SIG_SETMASK, &before_, nullptr);
}

}  // namespace pointreel
