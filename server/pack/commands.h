#pragma once

#include <CLI/CLI.hpp>

namespace pointreel {

/// Exit codes of every subcommand.
inline constexpr int kExitOk = 0, kExitFailed = 1, kExitUsage = 2;

/// Adds `pack` to the program. When it has run, `exit_code` holds its result.
void add_pack_command(CLI::App& app, int& exit_code);

/// Adds `info`, `verify` and `unpack`, likewise.
void add_inspect_commands(CLI::App& app, int& exit_code);

/// `pointreel-server: message` on standard error, as one line.
void print_error(const std::string& message);

}  // namespace pointreel
