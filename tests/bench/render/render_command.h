#pragma once

#include "common/command_line/command.h"

namespace pointreel::bench {

/// `pointreel-bench render`: compares pictures of every sequence in every mode with the ray-cast
/// truth. Writes report.md, report.json and PNG files.
void add_render_command(cli::Command app, int& exit_code);

}  // namespace pointreel::bench
