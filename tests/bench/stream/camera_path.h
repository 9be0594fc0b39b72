#pragma once

#include "tests/bench/stream/chapter.h"

namespace pointreel::bench {

/// For a camera that approaches from far away: the bytes that are fetched for its view, compared
/// with fetching all layers, and the effect on the pictures.
Result<nlohmann::json> run_camera_path(const StreamOptions& options, std::vector<Bar>& bars);

}  // namespace pointreel::bench
