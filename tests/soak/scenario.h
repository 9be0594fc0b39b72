#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <random>
#include <string>
#include <vector>

#include "pointreel/error.h"
#include "tests/link/link_emulator.h"

/// Everything that streams, at once and for long, under a sanitizer: what happens is random, what
/// must hold is not.
namespace pointreel::soak {

struct Options {
  std::chrono::seconds time{10};
  std::uint64_t seed = 1;
  std::filesystem::path scratch;  ///< a folder that is there
};

/// What a scenario did, for people; or what did not hold.
using Outcome = Result<std::string>;

/// Plays a package over HTTP through a link that is slow, breaks, lies and heals, with seeks,
/// scrubs, steps, other speeds and modes, while connections come and go and send rubbish. No frame
/// may ever be another than it says, and once the link is good every frame must come.
Outcome play_reel(const Options& options);

/// A publisher, viewers that stay, viewers that come and go, links that break; a publisher that is
/// started again. No frame may be another than it says, none may come twice or late, and once the
/// links are good frames must come.
Outcome watch_live(const Options& options);

/// Conditions of a bad link, now and then its connections reset or forgotten.
void worsen(LinkEmulator& link, std::mt19937_64& random);

}  // namespace pointreel::soak
