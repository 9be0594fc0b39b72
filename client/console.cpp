#include "client/console.h"

#include <cstdio>

#include <fmt/format.h>

namespace pointreel {
namespace {

/// A live stream that goes wrong for days must not fill the memory.
constexpr std::size_t kMostLines = 10'000;

}  // namespace

void ErrorLines::print(std::size_t source, const std::string& where, std::uint32_t frame,
                       const Error& error) {
  const std::lock_guard lock(mutex_);
  if (printed_.size() >= kMostLines || !printed_.insert({source, frame}).second) return;
  fmt::print(stderr, "pointreel: {}frame {}: {}\n", where, frame, error.message);
  if (printed_.size() == kMostLines)
    fmt::print(stderr, "pointreel: more broken frames are counted, but not told\n");
}

void TroubleLines::look(const Stage& stage) {
  said_.resize(stage.size());
  for (std::size_t i = 0; i < stage.size(); ++i) {
    const Playback& playback = stage.playback(i);
    const std::optional<std::string> trouble = playback.trouble();
    if (trouble && trouble != said_[i]) fmt::print(stderr, "pointreel: {}\n", *trouble);
    if (!trouble && said_[i]) fmt::print(stderr, "pointreel: {}: goes on\n", playback.name());
    said_[i] = trouble;
  }
}

}  // namespace pointreel
