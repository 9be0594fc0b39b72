#pragma once

#include "common/command_line/command.h"

namespace pointreel::bench {

/// Adds the command that computes what a long reel costs to store and to deliver to many.
void add_scale_command(cli::Command app, int& exit_code);

}  // namespace pointreel::bench
