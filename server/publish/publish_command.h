#pragma once

#include <CLI/CLI.hpp>

namespace pointreel {

/// Adds `publish` to the program. When it has run, `exit_code` holds its result.
void add_publish_command(CLI::App& app, int& exit_code);

}  // namespace pointreel
