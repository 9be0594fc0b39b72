#pragma once

#include "tests/bench/stream/chapter.h"

namespace pointreel::bench {

/// Playback while the link carries 100, then 5, then 100 Mbit/s: how long the picture stands still,
/// and how long it takes until the choice of layers suits the link.
Result<nlohmann::json> run_rate_change(const StreamOptions& options, std::vector<Bar>& bars);

}  // namespace pointreel::bench
