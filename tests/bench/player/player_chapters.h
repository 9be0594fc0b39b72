#pragma once

#include <vector>

#include <nlohmann/json.hpp>

#include "pointreel/error.h"
#include "tests/bench/stream/chapter.h"

namespace pointreel::bench {

/// Starts `pointreel play` with a local package: measures the time to the window and to the first
/// picture, and compares that with the picture that is drawn without a window.
Result<nlohmann::json> run_player_start(const StreamOptions& options, std::vector<Bar>& bars);

/// Drags the timeline to frames that are not loaded yet, of a local package and over a link. Also
/// checks that the window ends on the frame under the cursor.
Result<nlohmann::json> run_player_scrub(const StreamOptions& options, std::vector<Bar>& bars);

/// Plays with the bar, the panels and the help open, at normal and at double size, and measures the
/// time that the interface takes.
Result<nlohmann::json> run_player_interface(const StreamOptions& options, std::vector<Bar>& bars);

}  // namespace pointreel::bench
