#pragma once

#include <cstddef>
#include <exception>
#include <new>

#include <tbb/global_control.h>
#include <tbb/info.h>
#include <tbb/task_arena.h>

#include "pointreel/error.h"

namespace pointreel {

/// Calls `work()` with this many threads (0: one for each processor) and returns its Result. What
/// libraries below throw, above all if there is not enough memory, becomes an error.
template <class Work>
auto in_arena(int threads, const Work& work) -> decltype(work()) {
  try {
    if (threads <= 0) threads = tbb::info::default_concurrency();
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism,
                                    static_cast<std::size_t>(threads));
    tbb::task_arena arena(threads);
    return arena.execute(work);
  } catch (const std::bad_alloc&) {
    return fail(ErrorCode::limit, "not enough memory; try --threads 1");
  } catch (const std::exception& e) {
    return fail(e.what());
  }
}

}  // namespace pointreel
