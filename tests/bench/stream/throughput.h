#pragma once

#include <vector>

#include <nlohmann/json.hpp>

#include "tests/bench/stream/chapter.h"

namespace pointreel::bench {

/// What pointreel-server serves of a package in a second, against what nginx serves of the same
/// files in the same minute: whole layer files, and ranges of single frames.
Result<nlohmann::json> run_throughput(const StreamOptions& options, std::vector<Bar>& bars);

}  // namespace pointreel::bench
