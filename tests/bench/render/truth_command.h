#pragma once

#include <CLI/CLI.hpp>

namespace pointreel::bench {

/// `pointreel-bench truth`: the true surface of a sequence, frame by frame, as pointreel play
/// --record would show it were there no scanner, no codec and no splats.
void add_truth_command(CLI::App& app, int& exit_code);

}  // namespace pointreel::bench
