#pragma once

#include "tests/bench/stream/chapter.h"

namespace pointreel::bench {

/// 200 viewers at 10 Mbit/s each, first of a package and then of a live stream: how late frames
/// come, and what server and generator take of the processors.
Result<nlohmann::json> run_load(const StreamOptions& options, std::vector<Bar>& bars);

}  // namespace pointreel::bench
