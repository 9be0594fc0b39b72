#include <cstdio>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "common/base/memory.h"
#include "server/pack/commands.h"
#include "server/publish/publish_command.h"
#include "server/serve/serve_command.h"

int main(int argc, char** argv) {
  pointreel::keep_freed_memory();
  CLI::App app("Packs moving point clouds and serves them to players.", "pointreel-server");
  app.require_subcommand(1);
  app.set_help_all_flag("--help-all", "help for all subcommands");
  app.failure_message([](const CLI::App* failed, const CLI::Error& error) {
    return fmt::format("{}: {}, see --help\n", failed->get_name(), error.what());
  });
  int exit_code = pointreel::kExitOk;
  pointreel::add_pack_command(app, exit_code);
  pointreel::add_inspect_commands(app, exit_code);
  pointreel::add_serve_command(app, exit_code);
  pointreel::add_publish_command(app, exit_code);
  const char* footer =
      "Exit codes: 0 all is well; 1 it failed, or the package has faults; 2 the command line is "
      "wrong (info and verify: or names no package).";
  app.footer(footer);
  for (CLI::App* command : app.get_subcommands({})) command->footer(footer);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? pointreel::kExitOk : pointreel::kExitUsage;
  }
  return exit_code;
}
