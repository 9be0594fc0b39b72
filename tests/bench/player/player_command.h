#pragma once

#include "common/command_line/command.h"

namespace pointreel::bench {

/// `pointreel-bench player`: measures how soon a window and a picture appear, how soon a picture
/// follows a drag of the timeline, and how much time the interface takes. Uses the real window with
/// real events, on a virtual display (Xvfb).
void add_player_command(cli::Command app, int& exit_code);

}  // namespace pointreel::bench
