// Preloaded into a program, this writes where it is to standard error when it crashes: a crash in
// a driver or a display may not happen again for weeks.

#include <csignal>
#include <cstring>
#include <initializer_list>

#include <execinfo.h>
#include <unistd.h>

namespace {

void report(int signal) {
  // Everything here may be called in the handler of a signal.
  constexpr char kHeading[] = "crashed, at\n";
  [[maybe_unused]] const auto written = ::write(STDERR_FILENO, kHeading, std::strlen(kHeading));
  void* frames[64];
  ::backtrace_symbols_fd(frames, ::backtrace(frames, 64), STDERR_FILENO);
  ::raise(signal);  // the handler is no longer installed, so that the program ends as without it
}

[[gnu::constructor]] void install() {
  void* once[1];  // the first call loads a library, which a handler must not do
  ::backtrace(once, 1);
  struct sigaction action{};
  action.sa_handler = report;
  action.sa_flags = static_cast<int>(SA_RESETHAND);
  for (const int signal : {SIGSEGV, SIGBUS, SIGILL, SIGFPE, SIGABRT})
    ::sigaction(signal, &action, nullptr);
}

}  // namespace
