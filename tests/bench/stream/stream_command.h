#pragma once

#include "common/command_line/command.h"

namespace pointreel::bench {

/// Adds `pointreel-bench stream`, which measures streaming over links that are emulated on this
/// machine: first pictures, seeks, changes of the rate, live delays, many viewers and memory.
void add_stream_command(cli::Command app, int& exit_code);

}  // namespace pointreel::bench
