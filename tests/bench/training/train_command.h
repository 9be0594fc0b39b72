#pragma once

#include "common/command_line/command.h"

namespace pointreel::bench {

/// Adds `pointreel-bench train-context`, which trains context tables from synthetic data and writes
/// them, compressed, to a file like those in codec/octree/tables. The command sets `exit_code` to
/// 0, or to 1 if the file cannot be written.
void add_train_command(cli::Command app, int& exit_code);

}  // namespace pointreel::bench
