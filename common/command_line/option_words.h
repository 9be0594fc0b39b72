#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "common/command_line/command_table.h"

/// What --help, manual pages and completions say about an option.
namespace pointreel::cli {

/// The words that the option takes, if it takes no others; empty if it takes others.
std::vector<std::string> choices_of(const OptionEntry& option);

/// Its argument, such as "FOLDER" or "N", without CLI11's names of types; empty for flags.
std::string argument_of(const OptionEntry& option);

/// Its description, what it accepts, and its default, in one line. What the description already
/// tells in words ("default", the name of the variable in the environment) is not told again.
std::string description_of(const OptionEntry& option);

/// Breaks a text between words into lines of at most `width` characters.
std::string wrap(const std::string& text, std::size_t width);

}  // namespace pointreel::cli
