#include "client/session/console.h"

#include <cstdio>

#include <fmt/format.h>

namespace pointreel {
namespace {

/// A live stream that goes wrong for days must not fill the memory.
constexpr std::size_t kMostLines = 10'000;

void print_line(Progress* progress, const std::string& text) {
  const std::string line = "pointreel: " + text;
  if (progress != nullptr) {
    progress->print(line);
  } else {
    fmt::print(stderr, "{}\n", line);
  }
}

}  // namespace

void ErrorLines::set_progress(Progress* progress) {
  const std::lock_guard lock(mutex_);
  progress_ = progress;
}

void ErrorLines::print(std::size_t source, const std::string& where, std::uint32_t frame,
                       const Error& error) {
  const std::lock_guard lock(mutex_);
  if (printed_.size() >= kMostLines || !printed_.insert({source, frame}).second) return;
  newest_ = fmt::format("{}frame {}: {}", where, frame, error.message);
  print_line(progress_, *newest_);
  if (printed_.size() == kMostLines)
    print_line(progress_, "more broken frames are counted, but not told");
}

std::optional<std::string> ErrorLines::take_newest() {
  const std::lock_guard lock(mutex_);
  return std::exchange(newest_, std::nullopt);
}

std::string TroubleLines::now() const {
  for (const std::optional<std::string>& line : said_)
    if (line) return *line;
  return {};
}

void TroubleLines::look(const Stage& stage, Progress* progress) {
  said_.resize(stage.size());
  for (std::size_t i = 0; i < stage.size(); ++i) {
    const Playback& playback = stage.playback(i);
    const std::optional<std::string> trouble = playback.trouble();
    if (trouble && trouble != said_[i]) print_line(progress, *trouble);
    if (!trouble && said_[i]) print_line(progress, playback.name() + ": goes on");
    said_[i] = trouble;
  }
}

}  // namespace pointreel
