#include <fmt/format.h>

#include "common/command_line/completion.h"
#include "common/command_line/option_words.h"

namespace pointreel::cli {
namespace {

/// A text within a specification of _arguments and within single quotes.
std::string escaped(const std::string& text) {
  std::string all;
  for (const char c : text) {
    if (c == '\'') {
      all += "'\\''";
    } else {
      if (c == '\\' || c == '[' || c == ']' || c == ':') all += '\\';
      all += c;
    }
  }
  return all;
}

/// What _arguments does for a value.
std::string action(const Value& value) {
  switch (value.kind) {
    case Value::Kind::words:
      return fmt::format("({})", fmt::join(value.words, " "));
    case Value::Kind::files:
      return "_files";
    case Value::Kind::folders:
      return "_files -/";
    case Value::Kind::none:
    case Value::Kind::other:
      break;
  }
  return " ";
}

/// The specifications of an option, one for each of its names.
std::string specifications(const OptionEntry& option) {
  const Value value = value_of(option);
  // An option that may be repeated excludes nothing.
  const std::string before =
      option.most_values > 1 ? "*" : fmt::format("({})", fmt::join(option.names, " "));
  std::string all;
  for (const std::string& name : option.names) {
    std::string after;
    if (value.kind != Value::Kind::none) {
      after = fmt::format("{}:{}:{}", value_is_optional(option) ? ":" : "",
                          escaped(argument_of(option)), action(value));
    }
    const bool takes = value.kind != Value::Kind::none && name.starts_with("--");
    all += fmt::format("    '{}{}{}[{}]{}' \\\n", before, name, takes ? "=" : "",
                       escaped(short_description(option)), after);
  }
  return all;
}

std::string arguments_of(const CommandEntry& command) {
  std::string all;
  int number = 0;
  for (const OptionEntry& place : places_of(command)) {
    ++number;
    const bool many = place.most_values > 1;
    all += fmt::format("    '{}:{}:{}' \\\n", many ? "*" : std::to_string(number),
                       escaped(place.positional ? place.names.front() : argument_of(place)),
                       action(value_of(place)));
  }
  return all;
}

std::string function_of(const CommandEntry& command) {
  const std::string name = function_name(command);
  std::string text = name + "() {\n";
  if (!command.subcommands.empty())
    text += "  local curcontext=$curcontext state line\n  typeset -A opt_args\n";
  text += "  _arguments -C \\\n";
  for (const OptionEntry& option : command.options) text += specifications(option);
  if (command.subcommands.empty()) {
    text += arguments_of(command);
    text.erase(text.size() - 3);  // the last " \\\n"
    return text + "\n}\n";
  }
  text += fmt::format("    '1:command:{0}_commands' \\\n    '*::argument:->argument'\n", name);
  text += "  [[ $state != argument ]] || case $line[1] in\n";
  std::string described;
  for (const Subcommand& subcommand : command.subcommands) {
    text += fmt::format("    {0}) {1}_{0} ;;\n", subcommand.name, name);
    described += fmt::format("\n    '{}:{}'", subcommand.name, escaped(subcommand.summary));
  }
  // Where the command takes words of its own, too, all of them are of one kind: pack.
  const std::vector<OptionEntry> places = places_of(command);
  const std::string own = places.empty() ? "" : action(value_of(places.front()));
  if (!own.empty()) text += fmt::format("    *) {} ;;\n", own);
  return text + fmt::format(
                    "  esac\n}}\n\n{}_commands() {{\n  local -a commands=({})\n"
                    "  _describe command commands\n{}}}\n",
                    name, described, own.empty() ? "" : "  " + own + "\n");
}

}  // namespace

std::string zsh_completion(const std::vector<CommandEntry>& commands) {
  const std::string program = commands.front().path.front();
  const std::string function = function_name(commands.front());
  std::string text = fmt::format(
      "#compdef {0}\n# Completions of {0} for zsh, written by {0} --write-manuals.\n", program);
  for (const CommandEntry& command : commands) {
    text += '\n';
    text += function_of(command);
  }
  // zsh calls the file as a function the first time; it may also be read as a script.
  return text + fmt::format(
                    "\nif [[ $funcstack[1] == {0} ]]; then\n  {0} \"$@\"\nelse\n"
                    "  compdef {0} {1}\nfi\n",
                    function, program);
}

}  // namespace pointreel::cli
