#pragma once

#include <optional>
#include <string>

#include <CLI/CLI.hpp>

namespace pointreel {

/// Gives a program, and the subcommands that it has by now, the help and --version that all
/// programs have, and the program --write-manuals. The app's name is that of the program.
void add_common_options(CLI::App& app);

/// Prepares the process, parses the command line and runs the subcommand that it names. If the
/// program has nothing more to do, because it has printed its help, or what is wrong in one line,
/// the result is its exit status: 0, 2 for a wrong command line, or 1 if the subcommand threw an
/// exception.
std::optional<int> parse(CLI::App& app, int argc, const char* const* argv);

}  // namespace pointreel
