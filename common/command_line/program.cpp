#include "common/command_line/program.h"

#include <csignal>
#include <exception>
#include <memory>
#include <string>
#include <string_view>

#include <fmt/format.h>

#include "common/base/print.h"
#include "common/command_line/help_formatter.h"
#include "common/command_line/write_manuals.h"
#include "pointreel/version.h"

namespace pointreel {

void add_common_options(CLI::App& app) {
  const auto formatter = std::make_shared<HelpFormatter>();
  const auto add = [&](const auto& self, CLI::App& to) -> void {
    to.formatter(formatter);
    to.set_help_flag("-h,--help", "Print this help and exit");
    to.set_version_flag("--version", app.get_name() + " " POINTREEL_VERSION,
                        "Print the version and exit");
    for (CLI::App* command : to.get_subcommands({})) self(self, *command);
  };
  const auto write = [&app](const std::string& folder) {
    const auto written = write_manuals(app, folder);
    if (!written) print_error(app.get_name(), written.error().message);
    throw CLI::RuntimeError(written ? 0 : 1);  // there is nothing more to do
  };
  app.add_option_function<std::string>(
         "--write-manuals", write,
         "Write manual pages, and completions for bash, zsh and fish, to where they are looked for "
         "below FOLDER, such as ~/.local/share, and exit")
      ->type_name("FOLDER");
  add(add, app);
}

std::optional<int> parse(CLI::App& app, int argc, const char* const* argv) {
  // A file that exceeds a limit of the system (ulimit -f) is then reported like a full disk.
  std::signal(SIGXFSZ, SIG_IGN);
  try {
    app.parse(argc, argv);
    return std::nullopt;
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0 || error.get_name() == "RuntimeError") return app.exit(error);
    std::string command = app.get_name();
    for (const CLI::App* given = &app; !given->get_subcommands().empty();) {
      given = given->get_subcommands().front();
      command += " " + given->get_name();
    }
    std::string what = error.what();
    // CLI11's words for an option in a configuration file that it does not know.
    constexpr std::string_view kUnknown = "INI was not able to parse ";
    if (what.starts_with(kUnknown))
      what.replace(0, kUnknown.size(), "--config: there is no option ");
    print_error(app.get_name(), fmt::format("{}; see {} --help", what, command));
    return 2;
  } catch (const std::exception& error) {  // from a subcommand; most likely out of memory
    print_error(app.get_name(), error.what());
    return 1;
  }
}

}  // namespace pointreel
