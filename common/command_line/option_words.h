#pragma once

#include <string>
#include <vector>

#include <CLI/CLI.hpp>

/// What --help, manual pages and completions say about an option.
namespace pointreel {

/// "-o", "--output"; the name of an argument without dashes; a flag with its negation, "--loop",
/// "--no-loop".
std::vector<std::string> names_of(const CLI::Option& option);

/// The words that the option takes, if it takes no others; empty if it takes others.
std::vector<std::string> choices_of(const CLI::Option& option);

/// Its argument, such as "FOLDER" or "N", without CLI11's names of types; empty for flags.
std::string argument_of(const CLI::Option& option);

/// Its description, what it accepts, and its default, in one line. What the description already
/// tells in words ("default", the name of the variable in the environment) is not told again.
std::string description_of(const CLI::Option& option);

}  // namespace pointreel
