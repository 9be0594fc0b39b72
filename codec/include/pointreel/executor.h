#pragma once

#include <functional>

namespace pointreel {

/// Calls body(0) to body(count - 1), in any order, perhaps at the same time, and returns when all
/// of them have returned. How code that starts no threads of its own is lent some; without one (an
/// empty function) it does one after another. Results never depend on it.
using Executor = std::function<void(int count, const std::function<void(int)>& body)>;

inline void for_each(const Executor& executor, int count, const std::function<void(int)>& body) {
  if (executor && count > 1) {
    executor(count, body);
  } else {
    for (int i = 0; i < count; ++i) body(i);
  }
}

}  // namespace pointreel
