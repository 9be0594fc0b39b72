#pragma once

#include <stop_token>

#include "client/options/play_options.h"
#include "pointreel/error.h"

namespace pointreel {

/// Plays without a window or a display. Of one reel every frame once, in order, as fast as it goes;
/// live streams, and several sources, in real time.
Result<void> play_offscreen(const PlayOptions& options, const std::stop_token& stop);

}  // namespace pointreel
