#pragma once

#include "tests/bench/stream/chapter.h"

namespace pointreel::bench {

/// How soon after the link is back a package goes on and a live stream is live again: after the
/// server was killed, the link cut for ten seconds, connections reset or forgotten. Counts pictures
/// that are not what was packed.
Result<nlohmann::json> run_faults(const StreamOptions& options, std::vector<Bar>& bars);

}  // namespace pointreel::bench
