#pragma once

#include <exception>
#include <new>

#include "pointreel/error.h"

namespace pointreel {

/// Thrown by work that was asked to stop, where libraries lie between it and whoever is told.
class Stopped : public std::exception {
 public:
  /// `line` is a string literal, for people.
  explicit Stopped(const char* line) : line_(line) {}
  const char* what() const noexcept override { return line_; }

 private:
  const char* line_;
};

/// Returns `work()`, a Result, or an error if it throws: libraries below may, above all if there is
/// not enough memory or no thread to be had.
template <class Work>
auto without_exceptions(const Work& work, const char* no_memory = "not enough memory")
    -> decltype(work()) {
  try {
    return work();
  } catch (const std::bad_alloc&) {
    return fail(ErrorCode::limit, no_memory);
  } catch (const Stopped& stopped) {
    return fail(ErrorCode::cancelled, stopped.what());
  } catch (const std::exception& e) {
    return fail(e.what());
  }
}

}  // namespace pointreel
