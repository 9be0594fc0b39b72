#include "common/command_line/command_table.h"

#include <utility>

#include <fmt/format.h>

namespace pointreel {
namespace {

void add(std::vector<Command>& all, const CLI::App& app, std::vector<std::string> path) {
  path.push_back(app.get_name());
  Command command{path, &app, {}, {}, app.get_subcommands({})};
  for (const CLI::Option* option : app.get_options()) {
    if (option->get_group().empty()) continue;
    (option->get_positional() ? command.arguments : command.options).push_back(option);
  }
  const CLI::App* above = app.get_parent();
  if (above != nullptr && app.get_fallthrough() && above->get_config_ptr() != nullptr)
    command.options.push_back(above->get_config_ptr());
  const std::vector<const CLI::App*> subcommands = command.subcommands;
  all.push_back(std::move(command));
  for (const CLI::App* subcommand : subcommands) add(all, *subcommand, path);
}

}  // namespace

std::string Command::words() const {
  return fmt::format("{}", fmt::join(path.begin() + 1, path.end(), " "));
}

std::vector<Command> commands_of(const CLI::App& program) {
  std::vector<Command> all;
  add(all, program, {});
  return all;
}

std::string summary_of(const CLI::App& app) {
  const std::string text = app.get_description();
  const std::string line = text.substr(0, text.find('\n'));
  std::string sentence = line.substr(0, line.find(". "));
  if (sentence.ends_with('.')) sentence.pop_back();
  return sentence;
}

}  // namespace pointreel
