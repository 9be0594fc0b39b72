#pragma once

#include <string>
#include <vector>

#include <CLI/CLI.hpp>

namespace pointreel {

/// A program or one of its commands, as manual pages and completions see it. It points into the
/// table of options that --help is made of, and must not outlive it.
struct Command {
  std::vector<std::string> path;              ///< {"pointreel-server", "pack", "plan"}
  const CLI::App* app = nullptr;              ///< where it is defined
  std::vector<const CLI::Option*> options;    ///< those in --help, and the --config that it takes
  std::vector<const CLI::Option*> arguments;  ///< without dashes, in their order
  std::vector<const CLI::App*> subcommands;

  /// "pack plan"; empty for the program itself.
  std::string words() const;
};

/// All commands of a program: first the program itself, and each before its subcommands.
std::vector<Command> commands_of(const CLI::App& program);

/// The first line of an app's description says what it is for; only its first sentence.
std::string summary_of(const CLI::App& app);

}  // namespace pointreel
