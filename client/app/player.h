#pragma once

#include "client/options/play_options.h"

namespace pointreel {

/// Plays until the end, or until the user, SIGINT or SIGTERM ends it, and then writes the files
/// that the options name. Prints a line on standard error for each thing that goes wrong: for
/// frames that cannot be shown, and, if it returns false, for the reason why it ended.
bool play(const PlayOptions& options);

}  // namespace pointreel
