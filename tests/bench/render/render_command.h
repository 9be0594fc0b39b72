#pragma once

#include <CLI/CLI.hpp>

namespace pointreel::bench {

/// `pointreel-bench render`: pictures of every sequence in every mode against the ray-cast truth,
/// as report.md, report.json and PNG files.
void add_render_command(CLI::App& app, int& exit_code);

}  // namespace pointreel::bench
