#include "common/process/progress.h"

#include <algorithm>
#include <cstdio>
#include <utility>

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include "common/process/print.h"

namespace pointreel {
namespace {

constexpr auto kRedrawEvery = std::chrono::milliseconds(100);

std::size_t terminal_width() {
  winsize size{};
  const bool known = ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0;
  return known ? size.ws_col : 80;
}

std::string time_text(double seconds) {
  const auto s = static_cast<unsigned long>(seconds + 0.5);
  if (s < 3600) return fmt::format("{}:{:02}", s / 60, s % 60);
  return fmt::format("{}:{:02}:{:02}", s / 3600, s / 60 % 60, s % 60);
}

}  // namespace

std::string progress_line(const std::string& label, std::size_t done, std::size_t total,
                          double seconds, std::size_t width) {
  const double share = total == 0 ? 1.0 : static_cast<double>(done) / static_cast<double>(total);
  std::string tail = fmt::format(" {}/{}", done, total);
  if (done > 0 && done < total) {
    tail += fmt::format(", {} left", time_text(seconds * (1.0 - share) / share));
  }
  std::string line = label + " ";
  const std::size_t used = line.size() + tail.size() + 2;
  if (used + 5 <= width) {
    const std::size_t cells = std::min<std::size_t>(width - used, 40);
    const auto full = static_cast<std::size_t>(share * static_cast<double>(cells));
    line += '[' + std::string(full, '#') + std::string(cells - full, '.') + ']';
  }
  return (line + tail).substr(0, width);
}

Progress::Progress(std::string label, std::size_t total)
    : label_(std::move(label)),
      total_(total),
      terminal_(isatty(STDERR_FILENO) == 1),
      start_(Clock::now()) {}

Progress::~Progress() {
  const std::lock_guard lock(mutex_);
  wipe();
}

void Progress::tick() {
  const std::lock_guard lock(mutex_);
  ++done_;
  if (terminal_ && (!drawn_ || Clock::now() - last_drawn_ >= kRedrawEvery)) draw();
}

void Progress::print(const std::string& line) {
  const std::lock_guard lock(mutex_);
  wipe();
  std::fputs((visible(line) + "\n").c_str(), stderr);
}

void Progress::draw() {
  const std::chrono::duration<double> passed = Clock::now() - start_;
  // The last column stays free, since some terminals would wrap the line.
  const std::string line =
      progress_line(label_, done_, total_, passed.count(), terminal_width() - 1);
  std::fputs(("\r\x1b[K" + line).c_str(), stderr);
  std::fflush(stderr);
  drawn_ = true;
  last_drawn_ = Clock::now();
}

void Progress::wipe() {
  if (!drawn_) return;
  std::fputs("\r\x1b[K", stderr);
  std::fflush(stderr);
  drawn_ = false;
}

}  // namespace pointreel
