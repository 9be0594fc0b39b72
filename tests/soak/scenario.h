#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <random>
#include <string>
#include <vector>

#include "pointreel/error.h"
#include "tests/link/link_emulator.h"

/// Everything that streams, at the same time and for a long time, under a sanitizer. Random events
/// happen, but no frame may ever be wrong, and playback must recover.
namespace pointreel::soak {

struct Options {
  std::chrono::seconds time{10};
  std::uint64_t seed = 1;
  std::filesystem::path scratch;  ///< an existing folder
};

/// A summary for people, or the requirement that was violated.
using Outcome = Result<std::string>;

/// Plays a package over HTTP through a link that is slow, breaks, corrupts bytes and recovers, with
/// seeks, scrubbing, steps and changes of speed and mode, while other connections come and go and
/// send garbage. Every frame must be the one that it claims to be, and every frame must arrive once
/// the link is good.
Outcome play_reel(const Options& options);

/// Watches a live stream with viewers that stay and viewers that come and go, links that break, and
/// a publisher that is restarted. Every frame must be the one that it claims to be, none may arrive
/// twice or in the wrong order, and new frames must arrive once the links are good.
Outcome watch_live(const Options& options);

/// Gives a link random bad conditions, and occasionally resets or forgets its connections.
void worsen(LinkEmulator& link, std::mt19937_64& random);

}  // namespace pointreel::soak
