#pragma once

#include <CLI/CLI.hpp>

namespace pointreel::bench {

/// `pointreel-bench player`: how soon there is a window and a picture, how soon a picture follows
/// the hand that drags the time, and what the interface costs: in the real window, which Xvfb shows
/// nobody, with real events.
void add_player_command(CLI::App& app, int& exit_code);

}  // namespace pointreel::bench
