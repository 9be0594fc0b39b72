#pragma once

#include <CLI/CLI.hpp>

namespace pointreel {

/// Adds `serve` to the command line. When it was chosen, `exit_code` is 0 after SIGINT or SIGTERM
/// and 1 if there was nothing to serve or nowhere to listen.
void add_serve_command(CLI::App& app, int& exit_code);

}  // namespace pointreel
