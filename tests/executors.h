#pragma once

#include <atomic>
#include <thread>
#include <vector>

#include "pointreel/executor.h"

namespace pointreel {

/// Does the jobs in so many threads, or from the last to the first without any.
inline Executor threads_executor(int threads) {
  return [threads](int count, const std::function<void(int)>& body) {
    if (threads == 0) {
      for (int i = count; i-- > 0;) body(i);
      return;
    }
    std::atomic<int> next{0};
    std::vector<std::jthread> running;
    for (int thread = 0; thread < threads; ++thread) {
      running.emplace_back([&] {
        for (int i; (i = next.fetch_add(1)) < count;) body(i);
      });
    }
  };
}

/// Those that results must not depend on.
inline std::vector<Executor> some_executors() {
  std::vector<Executor> executors;
  for (const int threads : {0, 1, 2, 3, 7}) executors.push_back(threads_executor(threads));
  return executors;
}

}  // namespace pointreel
