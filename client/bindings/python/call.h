#pragma once

#include <chrono>
#include <exception>
#include <future>
#include <optional>
#include <stop_token>
#include <string>
#include <thread>
#include <utility>

#include <pybind11/pybind11.h>
#include <unistd.h>

#include "pointreel/error.h"

/// Calls from Python into C++.
namespace pointreel {

/// An error or a warning as Python shows it. They name the options of commands; those that the
/// module has, too, become its arguments.
std::string for_python(const std::string& line);

/// Raises pointreel.Error, with the code's name as its member `code`.
[[noreturn]] void raise(const Error& error);
/// Makes that class a member of the module.
void add_error(pybind11::module_& module);

template <class T>
T value_or_raise(Result<T> result) {
  if (!result) raise(result.error());
  if constexpr (!std::is_void_v<T>) return std::move(*result);
}

/// Lets other threads of Python run, as pybind11's gil_scoped_release does. But where Python ends
/// meanwhile, a daemon thread stays in here, as in Python 3.14: before, Python ends such a thread
/// by an unwinding that must not pass a destructor.
class ReleasedGil {
 public:
  ReleasedGil() : state_(PyEval_SaveThread()) {}
  ReleasedGil(const ReleasedGil&) = delete;
  ReleasedGil& operator=(const ReleasedGil&) = delete;
  ~ReleasedGil() {
    try {
      PyEval_RestoreThread(state_);
    } catch (...) {
      for (;;) pause();
    }
  }

 private:
  PyThreadState* state_;
};

/// Runs `work`, which returns a Result, while other threads of Python run.
template <class Work>
auto without_gil(const Work& work) {
  return value_or_raise([&] {
    const ReleasedGil released;
    return work();
  }());
}

inline constexpr std::chrono::milliseconds kSignalPeriod{50};

/// Calls `poll` again and again, while other threads of Python run, until it gives something.
/// `poll` waits for that no longer than the time that it gets. Raises KeyboardInterrupt, and what
/// else the handlers of signals raise.
template <class Poll>
auto until_signalled(const Poll& poll) {
  for (;;) {
    auto given = [&] {
      const ReleasedGil released;
      return poll(kSignalPeriod);
    }();
    if (given) return std::move(*given);
    if (PyErr_CheckSignals() != 0) throw pybind11::error_already_set();
  }
}

/// Runs `work`, which takes a stop token and returns a Result, on a thread of its own, so that
/// Ctrl-C ends it.
template <class Work>
auto interruptible(const Work& work) {
  using Outcome = decltype(work(std::stop_token()));
  std::stop_source stop;
  std::future<Outcome> outcome =
      std::async(std::launch::async, [&] { return work(stop.get_token()); });
  try {
    until_signalled([&](std::chrono::milliseconds time) -> std::optional<bool> {
      if (outcome.wait_for(time) == std::future_status::ready) return true;
      return std::nullopt;
    });
  } catch (...) {
    stop.request_stop();
    const ReleasedGil released;
    outcome.wait();
    throw;
  }
  return value_or_raise(outcome.get());
}

}  // namespace pointreel
