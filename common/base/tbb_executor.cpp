#include "common/base/tbb_executor.h"

#include <tbb/parallel_for.h>
#include <tbb/partitioner.h>
#include <tbb/task_arena.h>

namespace pointreel {

Executor tbb_executor() {
  return [](int count, const std::function<void(int)>& body) {
    tbb::this_task_arena::isolate(
        [&] { tbb::parallel_for(0, count, body, tbb::simple_partitioner()); });
  };
}

}  // namespace pointreel
