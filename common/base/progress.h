#pragma once

#include <chrono>
#include <cstddef>
#include <mutex>
#include <string>

namespace pointreel {

/// A bar with the time left on standard error if that is a terminal; otherwise silent. Any thread
/// may tick it. The bar's line is wiped when the progress ends, so that what is printed next stands
/// alone.
class Progress {
 public:
  /// `label` says what is being done, in a word or two.
  Progress(std::string label, std::size_t total);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// One more of the total is done.
  void tick();

  /// Prints a line to standard error, terminal or not, without tearing the bar.
  void print(const std::string& line);

 private:
  void draw();
  void wipe();

  using Clock = std::chrono::steady_clock;

  const std::string label_;
  const std::size_t total_;
  const bool terminal_;
  const Clock::time_point start_;
  std::mutex mutex_;  // of what follows
  std::size_t done_ = 0;
  bool drawn_ = false;
  Clock::time_point last_drawn_;
};

/// The line that the bar shows, at most `width` characters: label, bar, count, and time left once
/// there is something to judge it by.
std::string progress_line(const std::string& label, std::size_t done, std::size_t total,
                          double seconds, std::size_t width);

}  // namespace pointreel
