#pragma once

#include "common/command_line/command.h"

namespace pointreel::bench {

/// `pointreel-bench truth`: records the true surface of a sequence, as `pointreel play --record`
/// would show it if there were no scanner, codec and splats.
void add_truth_command(cli::Command app, int& exit_code);

}  // namespace pointreel::bench
