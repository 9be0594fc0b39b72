#include "common/command_line/option_words.h"

#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <sstream>

#include <fmt/format.h>

#include "common/base/words.h"

namespace pointreel::cli {
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

/// A number as people write it: whole ones exactly, others with at most nine digits.
std::string tidy(const std::string& text) {
  char* end = nullptr;
  const double number = std::strtod(text.c_str(), &end);
  const bool whole = text.find_first_not_of("0123456789") == std::string::npos;
  return whole || *end != '\0' ? text : number_text(number, 9);
}

/// The choices as --help lists them, or a range; empty if the checks of the option do not say.
std::string accepted(const OptionEntry& option) {
  const std::string checks = option.type.substr(checks_of(option.type));
  if (const std::string range = between(checks, "in [", "]"); !range.empty()) {
    const std::size_t dash = range.find(" - ");
    return fmt::format("{} to {}", tidy(range.substr(0, dash)), tidy(range.substr(dash + 3)));
  }
  return fmt::format("{}", fmt::join(choices_of(option), ", "));
}

/// A description begins with a capital, unless its first word is a name: "ldc: ...".
std::string capitalised(std::string text) {
  const std::size_t word = std::min(text.find(' '), text.size());
  if (word > 0 && text[word - 1] != ':')
    text[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(text[0])));
  return text;
}

}  // namespace

std::vector<std::string> choices_of(const OptionEntry& option) {
  // CLI11 writes a type as "INT:INT in [0 - 21]" or "TEXT:{auto,kd-tree}", and a choice that stands
  // for another value as "{scan->0,uniform->1}".
  std::istringstream list(between(option.type.substr(checks_of(option.type)), "{", "}"));
  std::vector<std::string> choices;
  for (std::string choice; std::getline(list, choice, ',');)
    choices.push_back(choice.substr(0, choice.find("->")));
  return choices;
}

std::string argument_of(const OptionEntry& option) {
  const std::string name = option.type.substr(0, checks_of(option.type));
  if (name == "INT" || name == "UINT") return "N";
  if (name == "FLOAT") return "NUMBER";
  return name == "TEXT" && !accepted(option).empty() ? "NAME" : name;
}

std::string description_of(const OptionEntry& option) {
  std::string text = capitalised(option.description);
  const auto says = [&text](const std::string& word) {
    return text.find(word) != std::string::npos;
  };
  std::vector<std::string> notes;
  if (option.required && !option.positional) notes.emplace_back("required");
  if (const auto all = accepted(option); !all.empty()) notes.push_back(all);
  const std::string preset = tidy(option.preset);
  if (!preset.empty() && !says("default")) notes.push_back("default " + preset);
  if (!option.variable.empty() && !says(option.variable))
    notes.push_back("or " + option.variable + " in the environment");
  for (const std::string& needed : option.needs) notes.push_back("needs " + needed);
  if (!notes.empty()) {
    // Notes join those that the description ends with.
    const bool joined = text.ends_with(')');
    if (joined) text.pop_back();
    text += fmt::format("{}{})", joined ? "; " : text.empty() ? "(" : " (", fmt::join(notes, "; "));
  }
  return text;
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

}  // namespace pointreel::cli
