#pragma once

#include <memory>
#include <system_error>
#include <thread>
#include <utility>

namespace pointreel {

/// Calls `work()` on a thread that nobody waits for, or right here where no thread can be had.
template <class Work>
void run_detached(Work work) {
  const auto shared = std::make_shared<Work>(std::move(work));
  try {
    std::thread([shared] { (*shared)(); }).detach();
  } catch (const std::system_error&) {
    (*shared)();
  }
}

}  // namespace pointreel
