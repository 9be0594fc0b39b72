#include "common/process/stop_signal.h"

#include <csignal>
#include <cstdlib>
#include <stop_token>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <unistd.h>

#include "server/pack/packer.h"
#include "tests/packed_reel.h"
#include "tests/wait.h"

namespace pointreel::stop_signal_test {
namespace {

void wait_for(const std::stop_token& stop) {
  wait_until([&] { return stop.stop_requested(); });
}

/// Packs in a process of its own, which sends itself a signal after the first frame.
[[noreturn]] void pack_and_signal(const PackOptions& options, int signal) {
  const StopSignal stop;
  PackListener listener;
  listener.stop = stop.token();
  listener.frame_done = [&] {
    kill(getpid(), signal);
    wait_for(listener.stop);
  };
  const auto summary = pack(options, listener);
  std::_Exit(!summary && summary.error().message.starts_with("interrupted") ? 7 : 8);
}

[[noreturn]] void signal_twice() {
  const StopSignal stop;
  kill(getpid(), SIGINT);
  wait_for(stop.token());
  ::sleep(1);
  kill(getpid(), SIGINT);
  ::alarm(60);
  ::pause();  // until one of the signals ends the process
  std::_Exit(8);
}

/// As `timeout` does: to the process and to its group.
[[noreturn]] void signal_twice_at_once() {
  {
    const StopSignal stop;
    kill(getpid(), SIGTERM);
    kill(getpid(), SIGINT);
    wait_for(stop.token());
    ::sleep(1);
  }
  std::_Exit(7);
}

class StopSignals : public PackTest {
 protected:
  // A process started afresh has no thread that would take the signal's default action.
  StopSignals() { GTEST_FLAG_SET(death_test_style, "threadsafe"); }
};

TEST_F(StopSignals, end_a_pack_without_leaving_files_behind) {
  write_frames(4);
  EXPECT_EXIT(pack_and_signal(options(), SIGINT), testing::ExitedWithCode(7), "");
  EXPECT_EXIT(pack_and_signal(options(), SIGTERM), testing::ExitedWithCode(7), "");
  EXPECT_THAT(outputs(), testing::IsEmpty());
}

TEST_F(StopSignals, kill_the_process_the_second_time) {
  EXPECT_EXIT(signal_twice(), testing::KilledBySignal(SIGINT), "");
}

TEST_F(StopSignals, count_as_one_if_they_come_at_once) {
  EXPECT_EXIT(signal_twice_at_once(), testing::ExitedWithCode(7), "");
}

TEST_F(StopSignals, kill_a_shell_background_process_the_second_time) {
  EXPECT_EXIT((std::signal(SIGINT, SIG_IGN), signal_twice()), testing::KilledBySignal(SIGINT), "");
}

TEST_F(StopSignals, are_handled_as_before_afterwards) {
  EXPECT_EXIT(
      {
        std::signal(SIGTERM, SIG_IGN);
        {
          const StopSignal stop;
        }
        std::raise(SIGTERM);
        std::_Exit(7);
      },
      testing::ExitedWithCode(7), "");
}

}  // namespace
}  // namespace pointreel::stop_signal_test
