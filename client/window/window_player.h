#pragma once

#include <stop_token>

#include "client/options/play_options.h"

namespace pointreel {

/// Plays in a window, in real time, until the user closes it. The window opens before what it
/// plays; it shows what is loading and what goes wrong, and plays what is dropped on it. False if
/// the last thing that was to be played could not be; the reason is on standard error.
bool play_in_window(const PlayOptions& options, const std::stop_token& stop);

}  // namespace pointreel
