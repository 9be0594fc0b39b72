#pragma once

#include "tests/bench/stream/chapter.h"

namespace pointreel::bench {

/// Playing while the link carries 100, 5 and 100 Mbit/s in turn: how long the picture stands still,
/// and how long it takes until what is fetched suits the link.
Result<nlohmann::json> run_rate_change(const StreamOptions& options, std::vector<Bar>& bars);

}  // namespace pointreel::bench
