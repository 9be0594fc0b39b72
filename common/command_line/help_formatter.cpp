#include "common/command_line/help_formatter.h"

#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <sstream>
#include <utility>

#include <fmt/format.h>

#include "common/base/words.h"

namespace pointreel {
namespace {

/// The part between two marks; empty if the marks are not there.
std::string between(const std::string& text, const std::string& begin, const std::string& end) {
  const std::size_t from = text.find(begin);
  if (from == std::string::npos) return {};
  const std::size_t to = text.find(end, from + begin.size());
  if (to == std::string::npos) return {};
  return text.substr(from + begin.size(), to - from - begin.size());
}

/// Where the names of the checks begin that CLI11 appends to the name of a type. A name such as
/// HOST:PORT may have a colon, too.
std::size_t checks_of(const std::string& type) {
  std::size_t first = type.size();
  for (const char* check : {":INT in", ":UINT in", ":FLOAT in", ":{", ":FILE", ":SIZE"})
    first = std::min(first, type.find(check));
  return first;
}

/// What the checks of an option accept, in words; empty if they do not say. CLI11 writes a type as
/// "INT:INT in [0 - 21]" or "TEXT:{auto,kd-tree}", and a choice that stands for another value as
/// "{scan->0,uniform->1}".
std::string accepted(const std::string& type) {
  const std::string checks = type.substr(checks_of(type));
  if (const std::string range = between(checks, "in [", "]"); !range.empty()) {
    const std::size_t dash = range.find(" - ");
    return fmt::format("{} to {}", number_text(std::atof(range.c_str()), 9),
                       number_text(std::atof(range.c_str() + dash + 3), 9));
  }
  std::istringstream choices(between(checks, "{", "}"));
  std::string words;
  for (std::string choice; std::getline(choices, choice, ',');)
    words += (words.empty() ? "" : ", ") + choice.substr(0, choice.find("->"));
  return words;
}

/// The argument of an option, without CLI11's names of types.
std::string argument_of(const std::string& type) {
  const std::string name = type.substr(0, checks_of(type));
  if (name == "INT" || name == "UINT") return "N";
  if (name == "FLOAT") return "NUMBER";
  return name == "TEXT" && !accepted(type).empty() ? "NAME" : name;
}

/// A description begins with a capital, unless its first word is a name: "ldc: ...".
std::string capitalised(std::string text) {
  const std::size_t word = std::min(text.find(' '), text.size());
  if (word > 0 && text[word - 1] != ':')
    text[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(text[0])));
  return text;
}

std::string default_of(const CLI::Option& option) {
  const std::string text = option.get_default_str();
  char* end = nullptr;
  const double number = std::strtod(text.c_str(), &end);
  return text.empty() || *end != '\0' ? text : number_text(number, 9);
}

}  // namespace

HelpFormatter::HelpFormatter() {
  column_width(kColumn);
  label("Positionals", "Arguments");
}

std::string HelpFormatter::make_group(std::string group, bool is_positional,
                                      std::vector<const CLI::Option*> options) const {
  const std::string text = CLI::Formatter::make_group(group, is_positional, std::move(options));
  // CLI11 puts two empty lines between groups, but one before the first.
  return is_positional || group == "Options" ? text : text.substr(1);
}

std::string HelpFormatter::make_option_name(const CLI::Option* option, bool is_positional) const {
  const std::string names = CLI::Formatter::make_option_name(option, is_positional);
  // CLI11 shows the value that the negated name of a flag stands for: "--loop,--no-loop{false}".
  std::string text;
  for (const char c : names.substr(0, names.find('{'))) text += c == ',' ? ", " : std::string(1, c);
  return text;
}

std::string HelpFormatter::make_option_opts(const CLI::Option* option) const {
  const std::string argument = argument_of(option->get_type_name());
  return argument.empty() ? "" : " " + argument;
}

std::string HelpFormatter::make_option_desc(const CLI::Option* option) const {
  std::string text = capitalised(option->get_description());
  const auto says = [&text](const std::string& word) {
    return text.find(word) != std::string::npos;
  };
  std::vector<std::string> notes;
  if (option->get_required() && !option->get_positional()) notes.emplace_back("required");
  if (option->get_type_size() > 0) {
    if (const auto all = accepted(option->get_type_name()); !all.empty()) notes.push_back(all);
    const std::string preset = default_of(*option);
    if (!preset.empty() && !says("default")) notes.push_back("default " + preset);
  }
  const std::string variable = option->get_envname();
  if (!variable.empty() && !says(variable))
    notes.push_back("or " + variable + " in the environment");
  for (const CLI::Option* needed : option->get_needs())
    notes.push_back("needs " + needed->get_name());
  if (!notes.empty()) {
    // Notes join those that the description ends with.
    const bool joined = text.ends_with(')');
    if (joined) text.pop_back();
    text += fmt::format("{}{})", joined ? "; " : text.empty() ? "(" : " (", fmt::join(notes, "; "));
  }
  return wrap(text, 80 - kColumn);
}

std::string HelpFormatter::make_description(const CLI::App* app) const {
  std::istringstream lines(app->get_description());
  std::string text;
  int number = 0;
  for (std::string line; std::getline(lines, line); ++number) {
    // The first line of a command's description is its heading (make_subcommand).
    if (number == 1 && app->get_parent() != nullptr) text += "\n";
    text += wrap(line, 80) + "\n";
  }
  return text + "\n";
}

std::string HelpFormatter::make_subcommand(const CLI::App* command) const {
  // The first line of a description says what a command is for.
  const std::string text = command->get_description();
  std::ostringstream out;
  CLI::detail::format_help(out, command->get_name(),
                           wrap(text.substr(0, text.find('\n')), 80 - kColumn), kColumn);
  return out.str();
}

std::string wrap(const std::string& text, std::size_t width) {
  std::istringstream words(text);
  std::string wrapped, line;
  for (std::string word; words >> word;) {
    if (!line.empty() && line.size() + 1 + word.size() > width) {
      wrapped += line + "\n";
      line.clear();
    }
    line += (line.empty() ? "" : " ") + word;
  }
  return wrapped + line;
}

}  // namespace pointreel
