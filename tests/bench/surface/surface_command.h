#pragma once

#include <CLI/CLI.hpp>

namespace pointreel::bench {

/// Adds `pointreel-bench surface -o FOLDER`, which compares ways to clean noisy sequences, and
/// writes surface.json, surface.md and plots into the folder.
void add_surface_command(CLI::App& app, int& exit_code);

}  // namespace pointreel::bench
