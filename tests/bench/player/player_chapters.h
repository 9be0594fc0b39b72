#pragma once

#include <vector>

#include <nlohmann/json.hpp>

#include "pointreel/error.h"
#include "tests/bench/stream/chapter.h"

namespace pointreel::bench {

/// Starts of `pointreel play` with a local package: the window with the name of what is loading,
/// the first picture, and whether that is the picture that is drawn without a window.
Result<nlohmann::json> run_player_start(const StreamOptions& options, std::vector<Bar>& bars);

/// Dragging the timeline to frames that are not there yet, of a local package and over a link; and
/// whether the frame under the cursor is what is to be seen in the end.
Result<nlohmann::json> run_player_scrub(const StreamOptions& options, std::vector<Bar>& bars);

/// Playing with the bar, the panels and the help open, at one and two times the size.
Result<nlohmann::json> run_player_interface(const StreamOptions& options, std::vector<Bar>& bars);

}  // namespace pointreel::bench
