#include <utility>

#include <fmt/format.h>

#include "common/command_line/completion.h"
#include "common/command_line/option_words.h"

namespace pointreel::cli {
namespace {

/// What the script offers for a value: words, or a word that stands for files or folders.
std::string bash_offer(const Value& value) {
  switch (value.kind) {
    case Value::Kind::words:
      return fmt::format("{}", fmt::join(value.words, " "));
    case Value::Kind::files:
      return "@files";
    case Value::Kind::folders:
      return "@folders";
    case Value::Kind::none:
    case Value::Kind::other:
      break;
  }
  return {};
}

/// A pattern of case for each word after the words of the command.
std::string pattern(const CommandEntry& command, const std::vector<std::string>& words) {
  std::string all;
  for (const std::string& word : words)
    all += fmt::format("{}'{} {}'", all.empty() ? "" : " | ", command.words(), word);
  return all;
}

constexpr const char* kBegin =
    R"(# Completions of {program} for bash, written by {program} --write-manuals.

# COMMAND OPTION: what the value of the option may be, in `offer`: words, @files, @folders or
# nothing. Fails if it needs no value.
{function}_value() {{
  offer=''
  case "$1 $2" in
)";

constexpr const char* kWalk = R"(    *) return 1 ;;
  esac
}}

{function}() {{
  local command='' offer='' options='' word i
  local cur=${{COMP_WORDS[COMP_CWORD]}} last=${{COMP_WORDS[COMP_CWORD - 1]}}
  COMPREPLY=()
  # bash takes "--codec=draco" apart.
  if [[ $cur == '=' ]]; then
    cur=''
  elif [[ $last == '=' ]]; then
    last=${{COMP_WORDS[COMP_CWORD - 2]}}
  fi
  for ((i = 1; i < COMP_CWORD; ++i)); do
    word=${{COMP_WORDS[i]}}
    case "$command $word" in
{subcommands}      *)
        if {function}_value "$command" "$word"; then
          i=$((i + 1))
          if [[ ${{COMP_WORDS[i]}} == '=' ]]; then i=$((i + 1)); fi
        fi
        ;;
    esac
  done
  if ! {function}_value "$command" "$last"; then
    case $command in
)";

constexpr const char* kEnd = R"(    esac
    if [[ $cur == -* ]]; then offer=$options; fi
  fi
  for word in $offer; do
    case $word in
      @files | @folders) compopt -o filenames 2>/dev/null ;;&
      @files) mapfile -t -O ${{#COMPREPLY[@]}} COMPREPLY < <(compgen -f -- "$cur") ;;
      @folders) mapfile -t -O ${{#COMPREPLY[@]}} COMPREPLY < <(compgen -d -- "$cur") ;;
      "$cur"*) COMPREPLY+=("$word") ;;
    esac
  done
}}

complete -F {function} {program}
)";

}  // namespace

std::string bash_completion(const std::vector<CommandEntry>& commands) {
  const std::string program = commands.front().path.front();
  const std::string function = function_name(commands.front());
  std::string values, subcommands, offers;
  for (const CommandEntry& command : commands) {
    std::vector<std::string> options, below;
    for (const OptionEntry& option : command.options) {
      options.insert(options.end(), option.names.begin(), option.names.end());
      if (!value_is_optional(option)) {
        values += fmt::format("    {}) offer='{}' ;;\n", pattern(command, option.names),
                              bash_offer(value_of(option)));
      }
    }
    for (const Subcommand& subcommand : command.subcommands) below.push_back(subcommand.name);
    if (!below.empty()) {
      subcommands += fmt::format("      {}) command=${{command:+$command }}$word ;;\n",
                                 pattern(command, below));
    }
    // The script does not count the words: it offers the same for each.
    std::vector<std::string> offered = below;
    for (const OptionEntry& place : places_of(command)) {
      if (const std::string offer = bash_offer(value_of(place)); !offer.empty()) {
        offered.push_back(offer);
        break;
      }
    }
    offers += fmt::format("      '{}') offer='{}' options='{}' ;;\n", command.words(),
                          fmt::join(offered, " "), fmt::join(options, " "));
  }
  return fmt::format(kBegin, fmt::arg("program", program), fmt::arg("function", function)) +
         values +
         fmt::format(kWalk, fmt::arg("function", function), fmt::arg("subcommands", subcommands)) +
         offers + fmt::format(kEnd, fmt::arg("program", program), fmt::arg("function", function));
}

}  // namespace pointreel::cli
