#pragma once

#include "client/play_options.h"
#include "common/base/error.h"

namespace pointreel {

/// Plays until the end, the user, SIGINT or SIGTERM ends it, and then writes what options.json asks
/// for. Prints one line on standard error for each frame that cannot be shown.
Result<void> play(const PlayOptions& options);

}  // namespace pointreel
