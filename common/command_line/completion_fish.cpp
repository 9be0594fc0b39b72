#include <fmt/format.h>

#include "common/command_line/completion.h"
#include "common/command_line/option_words.h"

namespace pointreel::cli {
namespace {

/// A text in single quotes, in which fish reads two escapes.
std::string quoted(const std::string& text) {
  std::string all = "'";
  for (const char c : text) {
    if (c == '\\' || c == '\'') all += '\\';
    all += c;
  }
  return all + "'";
}

/// What follows an option or an argument: options of `complete`.
std::string fish_offer(const Value& value) {
  switch (value.kind) {
    case Value::Kind::words:
      return " -x -a " + quoted(fmt::format("{}", fmt::join(value.words, " ")));
    case Value::Kind::files:
      return " -r -F";
    case Value::Kind::folders:
      return " -x -a '(__fish_complete_directories)'";
    case Value::Kind::other:
      return " -x";
    case Value::Kind::none:
      break;
  }
  return {};
}

constexpr const char* kAt =
    R"(# Completions of {program} for fish, written by {program} --write-manuals.

# Whether the words before the cursor name this command.
function _{function}_at
    set -l command ''
    set -l words (commandline -opc)
    set -l skip 0
    for word in $words[2..]
        if test $skip = 1
            set skip 0
            continue
        end
        switch "$command $word"
{subcommands}{values}        end
    end
    test "$command" = "$argv[1]"
end

complete -c {program} -f
)";

}  // namespace

std::string fish_completion(const std::vector<CommandEntry>& commands) {
  const std::string program = commands.front().path.front();
  const std::string function = function_name(commands.front());
  std::string subcommands, values, completions;
  for (const CommandEntry& command : commands) {
    const std::string words = command.words();
    const std::string at =
        fmt::format("complete -c {} -n \"_{}_at '{}'\"", program, function, words);
    for (const Subcommand& subcommand : command.subcommands) {
      const std::string name = subcommand.name;
      subcommands += fmt::format("            case '{0} {1}'\n                set command '{2}'\n",
                                 words, name, words.empty() ? name : words + " " + name);
      completions += fmt::format("{} -a {} -d {}\n", at, name, quoted(subcommand.summary));
    }
    for (const OptionEntry& option : command.options) {
      std::string names, skipped;
      for (const std::string& name : option.names) {
        const bool is_long = name.starts_with("--");
        names += fmt::format(" {} {}", is_long ? "-l" : "-s", name.substr(is_long ? 2 : 1));
        skipped += fmt::format(" '{} {}'", words, name);
      }
      completions += fmt::format("{}{}{} -d {}\n", at, names,
                                 value_is_optional(option) ? "" : fish_offer(value_of(option)),
                                 quoted(short_description(option)));
      if (!value_is_optional(option))
        values += fmt::format("            case{}\n                set skip 1\n", skipped);
    }
    for (const OptionEntry& place : places_of(command)) {
      const Value value = value_of(place);
      if (value.kind == Value::Kind::files) completions += at + " -F\n";
      if (value.kind == Value::Kind::folders)
        completions += at + " -a '(__fish_complete_directories)'\n";
    }
  }
  return fmt::format(kAt, fmt::arg("program", program), fmt::arg("function", function),
                     fmt::arg("subcommands", subcommands), fmt::arg("values", values)) +
         completions;
}

}  // namespace pointreel::cli
