#pragma once

#include <vector>

#include <CLI/CLI.hpp>

namespace pointreel {

/// Adds `plan`, `part`, `join` and `submit` to the command `pack`, and returns them. When one of
/// them has run, `exit_code` holds its result.
std::vector<CLI::App*> add_parts_commands(CLI::App& pack, int& exit_code);

}  // namespace pointreel
