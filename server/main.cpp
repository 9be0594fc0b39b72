#include "common/command_line/command.h"
#include "common/process/memory.h"
#include "common/process/standard_output.h"
#include "server/built_in_page.h"
#include "server/commands/commands.h"

int main(int argc, char** argv) {
  pointreel::keep_freed_memory();
  pointreel::cli::Program app("Packs sequences of point clouds and serves them to players.",
                              "pointreel-server");
  app.require_subcommand(1, 1);
  app.help_all_flag("--help-all", "Print the help of all subcommands and exit");
  int exit_code = pointreel::kExitOk;
  pointreel::add_pack_command(app, exit_code);
  pointreel::add_audio_command(app, exit_code);
  pointreel::add_edit_commands(app, exit_code);
  pointreel::add_inspect_commands(app, exit_code);
  pointreel::add_upload_command(app, exit_code);
  pointreel::add_serve_command(app, exit_code, {argv + 1, argv + argc}, pointreel::built_in_page());
  pointreel::add_publish_command(app, exit_code);
  const char* footer =
      "Exit codes: 0 success; 1 failure, or the package has faults;\n"
      "2 the command line is wrong, or the folder is not a package.";
  app.footer(footer);
  for (const pointreel::cli::Command command : app.subcommands()) command.footer(footer);
  app.add_common_options();
  return pointreel::finish_output("pointreel-server", app.parse(argc, argv).value_or(exit_code));
}
