#pragma once

#include "tests/bench/stream/chapter.h"

namespace pointreel::bench {

/// The resident memory of `pointreel play` while it loops through 100,000 frames over HTTP, and of
/// `pointreel-server serve` while it serves them and then handles 10,000 connections, one after the
/// other.
Result<nlohmann::json> run_memory(const StreamOptions& options, std::vector<Bar>& bars);

}  // namespace pointreel::bench
