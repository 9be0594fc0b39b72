#pragma once

#include <CLI/CLI.hpp>

namespace pointreel::bench {

/// `pointreel-bench stream`: first pictures, seeks, changes of the link, live delays, many viewers,
/// memory: what streaming takes under links that are emulated on this machine.
void add_stream_command(CLI::App& app, int& exit_code);

}  // namespace pointreel::bench
