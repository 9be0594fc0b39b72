#pragma once

#include <CLI/CLI.hpp>

namespace pointreel::bench {

/// Adds the command that computes what a long reel costs to store and to deliver to many.
void add_scale_command(CLI::App& app, int& exit_code);

}  // namespace pointreel::bench
