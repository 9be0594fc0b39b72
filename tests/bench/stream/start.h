#pragma once

#include "tests/bench/stream/chapter.h"

namespace pointreel::bench {

/// The time from opening an address to the first picture.
Result<nlohmann::json> run_start(const StreamOptions& options, std::vector<Bar>& bars);

}  // namespace pointreel::bench
