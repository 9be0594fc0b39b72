#pragma once

#include <cstddef>

#include <tbb/global_control.h>
#include <tbb/info.h>
#include <tbb/task_arena.h>

#include "common/threads/without_exceptions.h"

namespace pointreel {

/// Calls `work()` with this many threads (0: one for each processor), without_exceptions.
template <class Work>
auto in_arena(int threads, const Work& work) -> decltype(work()) {
  return without_exceptions(
      [&] {
        if (threads <= 0) threads = tbb::info::default_concurrency();
        const tbb::global_control limit(tbb::global_control::max_allowed_parallelism,
                                        static_cast<std::size_t>(threads));
        tbb::task_arena arena(threads);
        return arena.execute(work);
      },
      "not enough memory; try --threads 1");
}

}  // namespace pointreel
