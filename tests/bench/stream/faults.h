#pragma once

#include "tests/bench/stream/chapter.h"

namespace pointreel::bench {

/// The time from when a link works again until a package plays on and a live stream is live again,
/// after the server was killed, the link was cut for ten seconds, or connections were reset or
/// forgotten. Also counts pictures that differ from what was packed.
Result<nlohmann::json> run_faults(const StreamOptions& options, std::vector<Bar>& bars);

}  // namespace pointreel::bench
