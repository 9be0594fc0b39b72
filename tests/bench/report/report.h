#pragma once

#include <CLI/CLI.hpp>

namespace pointreel::bench {

/// Adds `pointreel-bench report -o FOLDER`, which measures everything and writes report.json,
/// report.md and its plots into the folder.
void add_report_command(CLI::App& app, int& exit_code);

}  // namespace pointreel::bench
