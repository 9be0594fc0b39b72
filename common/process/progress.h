#pragma once

#include <chrono>
#include <cstddef>
#include <mutex>
#include <string>

namespace pointreel {

/// A progress bar with the time left, on standard error. Draws nothing if that is not a terminal.
/// Any thread may call it. The destructor wipes the bar, so that it does not stay above what is
/// printed next.
class Progress {
 public:
  /// `label`: the current activity, in a word or two.
  Progress(std::string label, std::size_t total);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// Advances by one of the total.
  void tick();

  /// Prints a line to standard error, terminal or not, without garbling the bar.
  void print(const std::string& line);

 private:
  void draw();
  void wipe();

  using Clock = std::chrono::steady_clock;

  const std::string label_;
  const std::size_t total_;
  const bool terminal_;
  const Clock::time_point start_;
  std::mutex mutex_;  ///< guards the members below
  std::size_t done_ = 0;
  bool drawn_ = false;
  Clock::time_point last_drawn_;
};

/// The line of the bar, at most `width` characters: label, bar, count and, once the first part is
/// done, the time left.
std::string progress_line(const std::string& label, std::size_t done, std::size_t total,
                          double seconds, std::size_t width);

}  // namespace pointreel
