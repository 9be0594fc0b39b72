#pragma once

#include "client/options/play_options.h"

namespace pointreel {

/// Plays until the end, the user, SIGINT or SIGTERM ends it, and then writes what options.json asks
/// for. Says on standard error, in a line each, what goes wrong: frames that cannot be shown, and,
/// if it returns false, why it ended.
bool play(const PlayOptions& options);

}  // namespace pointreel
