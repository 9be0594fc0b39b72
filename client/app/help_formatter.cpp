#include "client/app/help_formatter.h"

#include <sstream>
#include <utility>

namespace pointreel {

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
  // Without the checks of the argument: the descriptions say what is accepted.
  const std::string type = option->get_type_name();
  const std::string argument = type.substr(0, type.find(':'));
  return argument.empty() ? "" : " " + argument;
}

std::string HelpFormatter::make_option_desc(const CLI::Option* option) const {
  return wrap(option->get_description(), 80 - kColumn);
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
