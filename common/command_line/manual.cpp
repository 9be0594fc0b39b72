#include "common/command_line/manual.h"

#include <algorithm>
#include <cctype>
#include <sstream>
#include <vector>

#include <fmt/format.h>

#include "common/command_line/option_words.h"
#include "pointreel/version.h"

namespace pointreel::cli {
namespace {

/// A text of one line, so that man shows each character as it is.
std::string literal(const std::string& text) {
  // A line that begins so would be a request.
  std::string escaped = text.starts_with('.') || text.starts_with('\'') ? "\\&" : "";
  for (const char c : text) {
    switch (c) {
      case '\\':
        escaped += "\\e";
        break;
      case '-':
        escaped += "\\-";
        break;
      case '\'':
        escaped += "\\(aq";
        break;
      case '`':
        escaped += "\\(ga";
        break;
      case '^':
        escaped += "\\(ha";
        break;
      case '~':
        escaped += "\\(ti";
        break;
      case '"':
        escaped += "\\(dq";
        break;
      default:
        escaped += c;
    }
  }
  return escaped;
}

std::string bold(const std::string& text) { return "\\fB" + literal(text) + "\\fR"; }
std::string italic(const std::string& text) { return "\\fI" + literal(text) + "\\fR"; }

std::string upper(std::string text) {
  for (char& c : text) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  return text;
}

/// A description goes on after the name of what it describes, so it needs no capital there.
std::string uncapitalised(std::string text) {
  const bool name = text.size() > 1 && std::isupper(static_cast<unsigned char>(text[1]));
  if (!text.empty() && !name && !text.starts_with("Pointreel"))
    text[0] = static_cast<char>(std::tolower(static_cast<unsigned char>(text[0])));
  return text;
}

std::string entry(const OptionEntry& option) {
  std::string names;
  for (const std::string& name : option.names) {
    const std::string shown = option.positional ? italic(name) : bold(name);
    names += (names.empty() ? "" : ", ") + shown;
  }
  const std::string argument = option.positional ? "" : argument_of(option);
  if (!argument.empty()) names += " " + italic(argument);
  return fmt::format(".TP\n{}\n{}\n", names, literal(description_of(option)));
}

std::string entries(const CommandEntry& command) {
  std::string text;
  if (!command.arguments.empty()) text += ".SH ARGUMENTS\n";
  for (const OptionEntry& argument : command.arguments) text += entry(argument);
  text += ".SH OPTIONS\n";
  std::vector<std::string> groups = {"Options"};
  for (const OptionEntry& option : command.options) {
    if (std::find(groups.begin(), groups.end(), option.group) == groups.end())
      groups.push_back(option.group);
  }
  for (const std::string& group : groups) {
    if (group != "Options") text += fmt::format(".SS \"{}\"\n", literal(group));
    for (const OptionEntry& option : command.options) {
      if (option.group == group) text += entry(option);
    }
  }
  return text;
}

/// A text of several lines: each begins a paragraph.
std::string paragraphs(const std::string& text) {
  std::istringstream lines(text);
  std::string all;
  for (std::string line; std::getline(lines, line);) {
    if (!line.empty()) all += ".PP\n" + literal(line) + "\n";
  }
  return all;
}

/// A text whose lines stay as they are.
std::string as_written(const std::string& text) {
  std::istringstream lines(text);
  std::string all = ".nf\n";
  for (std::string line; std::getline(lines, line);) all += literal(line) + "\n";
  return all + ".fi\n";
}

}  // namespace

std::string manual_name(const CommandEntry& command) {
  return fmt::format("{}", fmt::join(command.path, "-"));
}

std::string manual_page(const CommandEntry& command) {
  const std::string name = manual_name(command);
  const std::string call = fmt::format("{}", fmt::join(command.path, " "));
  std::string text = fmt::format(
      ".\\\" Written by {0} --write-manuals.\n"
      ".TH \"{1}\" 1 \"\" \"Pointreel {2}\" \"User Commands\"\n"
      ".SH NAME\n{3} \\- {4}\n"
      ".SH SYNOPSIS\n{5} {6}\n",
      command.path.front(), literal(upper(name)), POINTREEL_VERSION, literal(name),
      literal(uncapitalised(summary_of(command.description))), bold(call), literal(command.usage));
  text += ".SH DESCRIPTION\n" + paragraphs(command.description);
  text += entries(command);
  if (!command.subcommands.empty()) text += ".SH COMMANDS\n";
  for (const Subcommand& subcommand : command.subcommands) {
    text += fmt::format(".TP\n{}\n{}\n", bold(subcommand.name), literal(subcommand.summary));
  }
  if (!command.footer.empty()) text += ".SH NOTES\n" + as_written(command.footer);
  // The pages of the program, of the command above, and of the commands below.
  std::vector<std::string> others;
  for (std::size_t length = 1; length < command.path.size(); ++length) {
    others.push_back(
        fmt::format("{}", fmt::join(command.path.begin(), command.path.begin() + length, "-")));
  }
  for (const Subcommand& subcommand : command.subcommands)
    others.push_back(name + "-" + subcommand.name);
  std::string see;
  for (const std::string& other : others) see += (see.empty() ? "" : ",\n") + bold(other) + "(1)";
  if (!see.empty()) text += ".SH SEE ALSO\n" + see + "\n";
  return text;
}

}  // namespace pointreel::cli
