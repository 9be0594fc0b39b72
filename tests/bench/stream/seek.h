#pragma once

#include "tests/bench/stream/chapter.h"

namespace pointreel::bench {

/// From a jump to the exact picture, and from a move of the cursor of a drag to the coarse one, of
/// frames that nothing is there of; and whether each was the right one.
Result<nlohmann::json> run_seek(const StreamOptions& options, std::vector<Bar>& bars);

}  // namespace pointreel::bench
