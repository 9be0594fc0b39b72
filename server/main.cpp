#include "common/command_line/command.h"
#include "common/process/run_main.h"
#include "server/built_in_page.h"
#include "server/commands/commands.h"

namespace pointreel {
namespace {

int run(int argc, char** argv) {
  cli::Program app("Packs sequences of point clouds and serves them to players.",
                   "pointreel-server");
  app.require_subcommand(1, 1);
  app.help_all_flag("--help-all", "Print the help of all subcommands and exit");
  int exit_code = kExitOk;
  add_pack_command(app, exit_code);
  add_audio_command(app, exit_code);
  add_edit_commands(app, exit_code);
  add_inspect_commands(app, exit_code);
  add_upload_command(app, exit_code);
  add_serve_command(app, exit_code, {argv + 1, argv + argc}, built_in_page());
  add_page_command(app, exit_code, built_in_page());
  add_publish_command(app, exit_code);
  const char* footer =
      "Exit status: 0 success; 1 failure, or the package has faults;\n"
      "2 the command line is wrong, or the folder is not a package.";
  app.footer(footer);
  for (const cli::Command command : app.subcommands()) command.footer(footer);
  app.add_common_options();
  return app.parse(argc, argv).value_or(exit_code);
}

}  // namespace
}  // namespace pointreel

int main(int argc, char** argv) {
  return pointreel::run_main("pointreel-server", [&] { return pointreel::run(argc, argv); });
}
