#include "common/command_line/completion.h"

#include <algorithm>
#include <cctype>
#include <initializer_list>

#include <fmt/format.h>

#include "common/command_line/option_words.h"

namespace pointreel::cli {

Value value_of(const OptionEntry& option) {
  if (option.most_values == 0) return {};
  if (std::vector<std::string> words = choices_of(option); !words.empty())
    return {Value::Kind::words, std::move(words)};
  const std::string argument =
      option.positional && argument_of(option).empty() ? option.names.front() : argument_of(option);
  for (const char* folder : {"FOLDER", "REEL"}) {
    if (argument.starts_with(folder)) return {Value::Kind::folders, {}};
  }
  for (const char* file : {"FILE", "PATH", "INPUT", "SOURCE"}) {
    if (argument.starts_with(file)) return {Value::Kind::files, {}};
  }
  return {Value::Kind::other, {}};
}

std::vector<OptionEntry> places_of(const CommandEntry& command) {
  std::vector<OptionEntry> places;
  for (const OptionEntry& option : command.options) {
    if (option.has_place) places.push_back(option);
  }
  places.insert(places.end(), command.arguments.begin(), command.arguments.end());
  return places;
}

std::string function_name(const CommandEntry& command) {
  std::string name = fmt::format("_{}", fmt::join(command.path, "_"));
  std::replace(name.begin(), name.end(), '-', '_');
  return name;
}

std::string short_description(const OptionEntry& option) {
  std::string text = option.description;
  text = text.substr(0, text.find_first_of(";:("));
  text = text.substr(0, text.find(". "));
  while (text.ends_with(' ') || text.ends_with('.')) text.pop_back();
  if (!text.empty()) text[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(text[0])));
  return text;
}

}  // namespace pointreel::cli
