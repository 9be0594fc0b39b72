#pragma once

#include <vector>

#include <nlohmann/json.hpp>

#include "pointreel/error.h"
#include "tests/bench/measure.h"
#include "tests/bench/stream/chapter.h"

namespace pointreel::bench {

/// Live on loopback at 30 frames a second, publisher, server and viewer on this machine: from a
/// frame's capture until it is decoded and ready to be drawn; how soon a viewer is back after its
/// link carried nothing for 10 s; and what one viewer at 1 Mbit/s costs 49 others.
Result<nlohmann::json> run_live(const StreamOptions& options, std::vector<Bar>& bars);

}  // namespace pointreel::bench
