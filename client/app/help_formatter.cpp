#include "client/app/help_formatter.h"

#include <sstream>

#include <fmt/format.h>

namespace pointreel {

std::string HelpFormatter::make_option_name(const CLI::Option* option, bool is_positional) const {
  const std::string names = CLI::Formatter::make_option_name(option, is_positional);
  // CLI11 shows the value that the negated name of a flag stands for: "--loop,--no-loop{false}".
  std::string text;
  for (const char c : names.substr(0, names.find('{'))) text += c == ',' ? ", " : std::string(1, c);
  return text;
}

std::string HelpFormatter::make_option_opts(const CLI::Option* option) const {
  // Without the checks of the value, which descriptions tell in words.
  const std::string type = option->get_type_name();
  return option->get_type_size() == 0 ? "" : " " + type.substr(0, type.find(':'));
}

std::string HelpFormatter::make_option_desc(const CLI::Option* option) const {
  return wrap(option->get_description(), 80 - kColumn);
}

std::string wrap(const std::string& text, std::size_t width) {
  std::istringstream lines(text);
  std::string wrapped;
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    std::string part;
    for (std::string word; words >> word;) {
      if (!part.empty() && part.size() + 1 + word.size() > width) {
        wrapped += part + "\n";
        part.clear();
      }
      part += (part.empty() ? "" : " ") + word;
    }
    wrapped += part + "\n";
  }
  if (!wrapped.empty()) wrapped.pop_back();
  return wrapped;
}

}  // namespace pointreel
