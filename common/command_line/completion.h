#pragma once

#include <string>
#include <vector>

#include "common/command_line/command_table.h"

/// Scripts for shells, which complete the commands, the options and the values of a program. Each
/// is one text for all commands, the first of which is the program.
namespace pointreel::cli {

std::string bash_completion(const std::vector<CommandEntry>& commands);
std::string zsh_completion(const std::vector<CommandEntry>& commands);
std::string fish_completion(const std::vector<CommandEntry>& commands);

/// What may follow an option, or stand for an argument.
struct Value {
  enum class Kind { none, other, words, files, folders };
  Kind kind = Kind::none;
  std::vector<std::string> words;  ///< if `kind` is words
};

/// `none` for flags.
Value value_of(const OptionEntry& option);

/// Whether the option may stand without its value, as in --json [FILE]; true for flags.
inline bool value_is_optional(const OptionEntry& option) { return option.least_values == 0; }

/// What stands for the words of a command that are not options, in their order: its arguments, and
/// the options that may be given without their names.
std::vector<OptionEntry> places_of(const CommandEntry& command);

/// "_pointreel_server", and for a command "_pointreel_server_pack": a name of a function.
std::string function_name(const CommandEntry& command);

/// What an option does, in few words: the first sentence of its description, in single quotes if
/// the shell needs them.
std::string short_description(const OptionEntry& option);

}  // namespace pointreel::cli
