#pragma once

#include <stop_token>

#include "client/options/play_options.h"
#include "pointreel/error.h"

namespace pointreel {

/// Plays without a window or a display. A single reel is shown frame by frame, as fast as possible;
/// live streams and several sources are shown in real time.
Result<void> play_offscreen(const PlayOptions& options, const std::stop_token& stop);

}  // namespace pointreel
