#pragma once

#include "pointreel/executor.h"

namespace pointreel {

/// Calls body(0) to body(count - 1) with the executor, or one after another without one.
inline void for_each(const Executor& executor, int count, const std::function<void(int)>& body) {
  if (executor && count > 1) {
    executor(count, body);
  } else {
    for (int i = 0; i < count; ++i) body(i);
  }
}

}  // namespace pointreel
