#include "common/process/progress.h"

#include <cstdlib>
#include <string>
#include <thread>
#include <vector>

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

namespace pointreel::progress_test {
namespace {

using testing::EndsWith;
using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;

/// Returns what `work` prints to standard error while that is a terminal.
template <class Work>
std::string on_a_terminal(const Work& work) {
  const int terminal = posix_openpt(O_RDWR | O_NOCTTY);
  EXPECT_TRUE(terminal >= 0 && grantpt(terminal) == 0 && unlockpt(terminal) == 0);
  const int end = open(ptsname(terminal), O_RDWR | O_NOCTTY);
  const int before = dup(STDERR_FILENO);
  EXPECT_TRUE(end >= 0 && before >= 0 && dup2(end, STDERR_FILENO) >= 0);
  work();
  dup2(before, STDERR_FILENO);
  close(before);
  fcntl(terminal, F_SETFL, O_NONBLOCK);
  std::string text, part(4096, '\0');
  for (ssize_t size; (size = read(terminal, part.data(), part.size())) > 0;) {
    text.append(part, 0, static_cast<std::size_t>(size));
  }
  close(end);
  close(terminal);
  return text;
}

TEST(ProgressLine, shows_label_bar_count_and_time_left) {
  EXPECT_EQ(progress_line("pack", 25, 100, 10.0, 40), "pack [###............] 25/100, 0:30 left");
  EXPECT_THAT(progress_line("pack", 1, 1000, 10.0, 80), EndsWith(" 1/1000, 2:46:30 left"));
}

TEST(ProgressLine, shows_no_time_left_before_the_first_and_after_the_last_item) {
  EXPECT_EQ(progress_line("pack", 0, 4, 1.0, 21), "pack [..........] 0/4");
  EXPECT_EQ(progress_line("pack", 4, 4, 1.0, 21), "pack [##########] 4/4");
  EXPECT_EQ(progress_line("pack", 0, 0, 1.0, 21), "pack [##########] 0/0");
}

TEST(ProgressLine, never_exceeds_the_width) {
  for (std::size_t width = 0; width < 200; ++width) {
    for (const std::size_t done : {0u, 1u, 50u, 99u, 100u}) {
      EXPECT_LE(progress_line("verify", done, 100, 5.0, width).size(), width);
    }
  }
  EXPECT_EQ(progress_line("pack", 0, 4, 1.0, 14), "pack  0/4");  // there is no room for a bar
}

TEST(Progress, is_silent_if_standard_error_is_not_a_terminal) {
  testing::internal::CaptureStderr();
  {
    Progress progress("pack", 2);
    progress.tick();
    progress.print("a line");
    progress.tick();
  }
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "a line\n");
}

TEST(Progress, draws_a_bar_on_a_terminal_and_clears_it_at_the_end) {
  const std::string text = on_a_terminal([] {
    Progress progress("pack", 2);
    progress.tick();
  });
  EXPECT_THAT(text, StartsWith("\r\x1b[Kpack ["));
  EXPECT_THAT(text, HasSubstr(" 1/2"));
  EXPECT_THAT(text, Not(HasSubstr("\n")));
  EXPECT_THAT(text, EndsWith("\r\x1b[K"));
}

TEST(Progress, prints_lines_on_lines_of_their_own) {
  const std::string text = on_a_terminal([] {
    Progress progress("pack", 2);
    progress.tick();
    progress.print("a line");
  });
  EXPECT_THAT(text, EndsWith("1/2, 0:00 left\r\x1b[Ka line\r\n"));
}

TEST(Progress, counts_ticks_from_any_thread) {
  const std::string text = on_a_terminal([] {
    Progress progress("pack", 400);
    std::vector<std::thread> threads;
    for (int i = 0; i < 4; ++i) {
      threads.emplace_back([&] {
        for (int tick = 0; tick < 99; ++tick) progress.tick();
      });
    }
    for (std::thread& thread : threads) thread.join();
    progress.print("a line");  // after it, the bar is redrawn at once
    progress.tick();
  });
  EXPECT_THAT(text, HasSubstr(" 397/400"));
}

}  // namespace
}  // namespace pointreel::progress_test
