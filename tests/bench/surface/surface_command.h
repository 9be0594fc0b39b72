#pragma once

#include "common/command_line/command.h"

namespace pointreel::bench {

/// Adds `pointreel-bench surface -o FOLDER`, which compares ways to clean noisy sequences, and
/// writes surface.json, surface.md and plots into the folder.
void add_surface_command(cli::Command app, int& exit_code);

}  // namespace pointreel::bench
