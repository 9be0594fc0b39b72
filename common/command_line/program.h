#pragma once

#include <optional>
#include <string>

#include <CLI/CLI.hpp>

namespace pointreel {

/// Gives a program, and the subcommands that it has by now, the help and --version that all
/// programs have. The app's name is that of the program.
void add_common_options(CLI::App& app);

/// Parses the command line. If the program has nothing more to do, because it has printed its help,
/// or what is wrong in one line, the result is its exit status: 0 or 2.
std::optional<int> parse(CLI::App& app, int argc, const char* const* argv);

}  // namespace pointreel
