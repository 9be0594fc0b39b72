#pragma once

#include <stop_token>

#include "client/play_options.h"
#include "common/base/error.h"

namespace pointreel {

/// Plays in a window, in real time, until the user closes it.
Result<void> play_in_window(const PlayOptions& options, const std::stop_token& stop);

}  // namespace pointreel
