#pragma once

#include <atomic>
#include <new>

#include "pointreel/executor.h"

namespace pointreel {

/// Calls body(0) to body(count - 1) with the executor, or one after another without one. If a call
/// lacks memory, so does this; nothing is thrown through the executor's threads. It is static
/// because not everything is compiled with exceptions.
static inline void for_each(const Executor& executor, int count,
                            const std::function<void(int)>& body) {
  if (!executor || count <= 1) {
    for (int i = 0; i < count; ++i) body(i);
    return;
  }
#ifdef __cpp_exceptions
  std::atomic<bool> no_memory{false};
  executor(count, [&](int i) {
    try {
      body(i);
    } catch (const std::bad_alloc&) {
      no_memory = true;
    }
  });
  if (no_memory) throw std::bad_alloc();
#else
  executor(count, body);
#endif
}

}  // namespace pointreel
