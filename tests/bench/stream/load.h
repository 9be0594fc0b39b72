#pragma once

#include "tests/bench/stream/chapter.h"

namespace pointreel::bench {

/// 200 viewers at 10 Mbit/s each, first of a package and then of a live stream: the delays of the
/// frames, and the processor time of the server and of the generator.
Result<nlohmann::json> run_load(const StreamOptions& options, std::vector<Bar>& bars);

}  // namespace pointreel::bench
