#include "common/command_line/help_formatter.h"

#include <sstream>
#include <utility>

#include "common/command_line/option_words.h"

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

std::string HelpFormatter::make_option_name(const CLI::Option* option, bool) const {
  return CLI::detail::join(names_of(*option), ", ");
}

std::string HelpFormatter::make_option_opts(const CLI::Option* option) const {
  const std::string argument = argument_of(*option);
  return argument.empty() ? "" : " " + argument;
}

std::string HelpFormatter::make_option_desc(const CLI::Option* option) const {
  return wrap(description_of(*option), 80 - kColumn);
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
