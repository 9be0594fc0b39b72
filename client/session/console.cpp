#include "client/session/console.h"

#include <cstdio>

#include <fmt/format.h>

#include "common/process/print.h"

namespace pointreel {
namespace {

/// A live stream that is broken for days must not fill the memory.
constexpr std::size_t kMaxLines = 10'000;

void print_line(Progress* progress, const std::string& text) {
  if (progress != nullptr)
    progress->print("pointreel: " + text);
  else
    print_error("pointreel", text);
}

}  // namespace

void ErrorLines::set_progress(Progress* progress) {
  const std::lock_guard lock(mutex_);
  progress_ = progress;
}

void ErrorLines::print(std::size_t source, const std::string& where,
                       std::optional<std::uint32_t> frame, const Error& error) {
  const std::lock_guard lock(mutex_);
  if (printed_.size() >= kMaxLines || !printed_.insert({source, frame}).second) return;
  const int times = ++times_[{source, error.message}];
  if (times > 2) return;
  const std::string what = !frame       ? "sound"
                           : times == 1 ? fmt::format("frame {}", *frame)
                                        : "other frames";
  newest_ = fmt::format("{}{}: {}{}", where, what, error.message,
                        times == 1 ? "" : " (they are counted but not listed)");
  print_line(progress_, *newest_);
  if (printed_.size() == kMaxLines)
    print_line(progress_, "further broken frames are counted but not listed");
}

std::optional<std::string> ErrorLines::take_newest() {
  const std::lock_guard lock(mutex_);
  return std::exchange(newest_, std::nullopt);
}

std::string TroubleLines::now() const {
  for (const std::optional<std::string>& trouble : troubles_)
    if (trouble) return *trouble;
  return {};
}

void TroubleLines::look(const Stage& stage, Progress* progress) {
  troubles_.resize(stage.size());
  for (std::size_t i = 0; i < stage.size(); ++i) {
    const Playback& playback = stage.playback(i);
    std::optional<std::string> trouble = playback.trouble();
    if (trouble && trouble != troubles_[i]) print_line(progress, *trouble);
    if (!trouble && troubles_[i]) print_line(progress, playback.name() + ": connected");
    troubles_[i] = std::move(trouble);
  }
}

}  // namespace pointreel
