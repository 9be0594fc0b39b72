#pragma once

#include "tests/bench/stream/chapter.h"

namespace pointreel::bench {

/// The time from a seek to the exact picture, and from a move while dragging to the coarse picture,
/// for frames of which nothing has been fetched. Also checks that each picture is the right one.
Result<nlohmann::json> run_seek(const StreamOptions& options, std::vector<Bar>& bars);

}  // namespace pointreel::bench
