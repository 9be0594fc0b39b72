#pragma once

#include <vector>

#include <nlohmann/json.hpp>

#include "pointreel/error.h"
#include "tests/bench/measure.h"
#include "tests/bench/stream/chapter.h"

namespace pointreel::bench {

/// A live stream of 30 frames per second with publisher, server and viewers on this machine: the
/// delay from capture until a frame is decoded and ready to be drawn; how soon a viewer is live
/// again after its link carried nothing for 10 s; and the delay that one viewer at 1 Mbit/s causes
/// 49 others.
Result<nlohmann::json> run_live(const StreamOptions& options, std::vector<Bar>& bars);

}  // namespace pointreel::bench
