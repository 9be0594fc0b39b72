#pragma once

#include "tests/bench/stream/chapter.h"

namespace pointreel::bench {

/// A camera that comes from far to near: the bytes that are fetched for what it shows, against all
/// layers, and what that does to the pictures.
Result<nlohmann::json> run_camera_path(const StreamOptions& options, std::vector<Bar>& bars);

}  // namespace pointreel::bench
