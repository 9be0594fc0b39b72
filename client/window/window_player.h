#pragma once

#include <stop_token>

#include "client/options/play_options.h"

namespace pointreel {

/// Plays in a window, in real time, until the user closes it. The window is there before what it
/// plays, tells what is loading and what goes wrong, and takes what is dropped on it. False: the
/// last thing that was to be played could not be; why has been said on standard error.
bool play_in_window(const PlayOptions& options, const std::stop_token& stop);

}  // namespace pointreel
