#include "common/threads/tbb_executor.h"

#ifdef __SANITIZE_THREAD__
#include <algorithm>
#include <atomic>
#include <thread>
#include <vector>
#else
#include <tbb/parallel_for.h>
#include <tbb/partitioner.h>
#include <tbb/task_arena.h>
#include <tbb/task_group.h>
#endif

namespace pointreel {
namespace {

#ifdef __SANITIZE_THREAD__
// Debian's TBB is not instrumented, so ThreadSanitizer does not see how TBB orders the calls of the
// body, and would report each of them. It does understand plain threads.
void run(int count, const std::function<void(int)>& body) {
  std::atomic<int> next = 0;
  std::vector<std::jthread> threads;
  for (int i = 0; i < std::min(count, 4); ++i) {
    threads.emplace_back([&] {
      for (int index; (index = next.fetch_add(1)) < count;) body(index);
    });
  }
}
#else
void run(int count, const std::function<void(int)>& body) {
  // What is thrown in a loop around this one must not end it halfway without a word: its caller
  // would go on with what is missing.
  tbb::task_group_context own(tbb::task_group_context::isolated);
  tbb::this_task_arena::isolate(
      [&] { tbb::parallel_for(0, count, body, tbb::simple_partitioner(), own); });
}
#endif

}  // namespace

Executor tbb_executor() { return run; }

}  // namespace pointreel
