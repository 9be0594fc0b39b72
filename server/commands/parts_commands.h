#pragma once

#include "common/command_line/command.h"

namespace pointreel {

/// Adds `plan`, `part`, `join` and `submit` to the command `pack`. When one of them has run,
/// `exit_code` holds its result.
void add_parts_commands(cli::Command pack, int& exit_code);

}  // namespace pointreel
