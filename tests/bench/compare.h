#pragma once

#include "common/command_line/command.h"

namespace pointreel::bench {

/// Adds `pointreel-bench compare A B`: every metric of codec/distance/distance.h for two files, as
/// a table and as JSON. The command runs while the command line is parsed, and sets `exit_code` to
/// 0, or to 1 with one line on standard error.
void add_compare_command(cli::Command app, int& exit_code);

}  // namespace pointreel::bench
