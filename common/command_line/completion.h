#pragma once

#include <string>
#include <vector>

#include "common/command_line/command_table.h"

/// Scripts for shells, which complete the commands, the options and the values of a program. Each
/// is one text for all commands, the first of which is the program (commands_of).
namespace pointreel {

std::string bash_completion(const std::vector<Command>& commands);
std::string zsh_completion(const std::vector<Command>& commands);
std::string fish_completion(const std::vector<Command>& commands);

/// What may follow an option, or stand for an argument.
struct Value {
  enum class Kind { none, other, words, files, folders };
  Kind kind = Kind::none;
  std::vector<std::string> words;  ///< if `kind` is words
};

/// `none` for flags.
Value value_of(const CLI::Option& option);

/// Whether the option may stand without its value, as in --json [FILE]; true for flags.
inline bool value_is_optional(const CLI::Option& option) {
  return option.get_items_expected_min() == 0;
}

/// "_pointreel_server", and for a command "_pointreel_server_pack": a name of a function.
std::string function_name(const Command& command);

/// What an option does, in few words: the first sentence of its description, in single quotes if
/// the shell needs them.
std::string short_description(const CLI::Option& option);

}  // namespace pointreel
