#pragma once

#include <functional>
#include <stop_token>
#include <utility>

#include "common/threads/without_exceptions.h"
#include "pointreel/executor.h"

namespace pointreel {

/// An executor whose jobs throw Stopped(`line`) once `stop` is requested.
inline Executor stoppable(Executor executor, std::stop_token stop, const char* line) {
  return [executor = std::move(executor), stop = std::move(stop), line](
             int count, const std::function<void(int)>& body) {
    executor(count, [&](int index) {
      if (stop.stop_requested()) throw Stopped(line);
      body(index);
    });
  };
}

}  // namespace pointreel
