#include "common/threads/tbb_executor.h"

#include <atomic>
#include <chrono>
#include <thread>
#include <vector>

#include <gtest/gtest.h>
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include "common/threads/stoppable.h"
#include "common/threads/without_exceptions.h"
#include "tests/wait.h"

namespace pointreel::tbb_executor_test {
namespace {

TEST(TbbExecutor, does_every_job_once_and_waits_for_all) {
  for (const int threads : {1, 2}) {
    tbb::task_arena arena(threads);
    std::vector<int> done(100);
    arena.execute(
        [&] { tbb_executor()(100, [&](int job) { ++done[static_cast<std::size_t>(job)]; }); });
    EXPECT_EQ(done, std::vector<int>(100, 1));
  }
}

TEST(TbbExecutor, begins_no_unrelated_work_while_it_waits_for_its_jobs) {
  // The threads sleep, so there may be more of them than processors.
  const tbb::global_control more(tbb::global_control::max_allowed_parallelism, 4);
  tbb::task_arena arena(4);
  std::atomic<int> nested{0};
  arena.execute([&] {
    tbb::parallel_for(0, 40, [&](int) {
      static thread_local bool busy = false;
      if (busy) ++nested;
      busy = true;
      const auto caller = std::this_thread::get_id();
      tbb_executor()(3, [&](int) {
        // A helper takes longer than the caller, which then has to wait.
        const bool helps = std::this_thread::get_id() != caller;
        work_for(std::chrono::microseconds(helps ? 2000 : 200));
      });
      busy = false;
    });
  });
  EXPECT_EQ(nested, 0);
}

TEST(TbbExecutor, work_that_was_asked_to_stop_is_an_error) {
  std::stop_source stop;
  int done = 0;
  const auto work = [&]() -> Result<int> {
    tbb::task_arena arena(1);
    arena.execute([&] {
      stoppable(tbb_executor(), stop.get_token(), "stopped here")(10, [&](int) {
        if (++done == 3) stop.request_stop();
      });
    });
    return done;
  };
  const auto outcome = without_exceptions(work);
  ASSERT_FALSE(outcome);
  EXPECT_EQ(outcome.error().code, ErrorCode::cancelled);
  EXPECT_EQ(outcome.error().message, "stopped here");
  EXPECT_EQ(done, 3);
}

}  // namespace
}  // namespace pointreel::tbb_executor_test
