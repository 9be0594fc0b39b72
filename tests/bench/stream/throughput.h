#pragma once

#include <vector>

#include <nlohmann/json.hpp>

#include "tests/bench/stream/chapter.h"

namespace pointreel::bench {

/// The throughput of pointreel-server for a package, compared with that of nginx for the same files
/// in the same run: whole layer files, and ranges of single frames.
Result<nlohmann::json> run_throughput(const StreamOptions& options, std::vector<Bar>& bars);

}  // namespace pointreel::bench
