#pragma once

#include "common/command_line/command.h"

namespace pointreel::bench {

/// Adds `pointreel-bench report -o FOLDER`, which measures everything and writes report.json,
/// report.md and its plots into the folder.
void add_report_command(cli::Command app, int& exit_code);

}  // namespace pointreel::bench
