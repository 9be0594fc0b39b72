#pragma once

#include <CLI/CLI.hpp>

namespace pointreel::bench {

/// `pointreel-bench truth`: records the true surface of a sequence, as `pointreel play --record`
/// would show it if there were no scanner, codec and splats.
void add_truth_command(CLI::App& app, int& exit_code);

}  // namespace pointreel::bench
