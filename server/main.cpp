#include <exception>
#include <memory>
#include <sstream>
#include <string>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "common/base/memory.h"
#include "common/base/standard_output.h"
#include "server/commands.h"

namespace {

/// Wraps the descriptions of options, which CLI11 prints on one line.
class Formatter : public CLI::Formatter {
 public:
  std::string make_option_desc(const CLI::Option* option) const override {
    const std::size_t width = kTerminalWidth - get_column_width();
    std::istringstream words(option->get_description());
    std::string lines, line;
    for (std::string word; words >> word;) {
      if (!line.empty() && line.size() + 1 + word.size() > width) {
        lines += line + "\n";
        line.clear();
      }
      line += (line.empty() ? "" : " ") + word;
    }
    return lines + line;
  }

 private:
  static constexpr std::size_t kTerminalWidth = 100;
};

}  // namespace

int main(int argc, char** argv) {
  pointreel::keep_freed_memory();
  CLI::App app("Packs sequences of point clouds and serves them to players.", "pointreel-server");
  app.formatter(std::make_shared<Formatter>());
  app.require_subcommand(1);
  app.set_help_all_flag("--help-all", "Print the help of all subcommands and exit");
  app.failure_message([](const CLI::App* failed, const CLI::Error& error) {
    return fmt::format("{}: {}, see --help\n", failed->get_name(), error.what());
  });
  int exit_code = pointreel::kExitOk;
  pointreel::add_pack_command(app, exit_code);
  pointreel::add_inspect_commands(app, exit_code);
  pointreel::add_serve_command(app, exit_code);
  pointreel::add_publish_command(app, exit_code);
  const char* footer =
      "Exit codes: 0 success; 1 failure, or the package has faults;\n"
      "2 the command line is wrong, or the folder is not a package.";
  app.footer(footer);
  for (CLI::App* command : app.get_subcommands({})) command->footer(footer);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    exit_code = app.exit(error) == 0 ? pointreel::kExitOk : pointreel::kExitUsage;
  } catch (const std::exception& error) {  // most likely out of memory
    pointreel::print_error(error.what());
    exit_code = pointreel::kExitFailed;
  }
  return pointreel::finish_output("pointreel-server", exit_code);
}
