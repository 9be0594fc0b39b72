#pragma once

#include <CLI/CLI.hpp>

namespace pointreel::bench {

/// Adds `pointreel-bench stream`, which measures streaming over links that are emulated on this
/// machine: first pictures, seeks, changes of the rate, live delays, many viewers and memory.
void add_stream_command(CLI::App& app, int& exit_code);

}  // namespace pointreel::bench
