#include <chrono>
#include <exception>
#include <memory>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "client/app/help_formatter.h"
#include "client/app/play_command.h"
#include "client/app/player.h"
#include "common/base/memory.h"
#include "common/base/standard_output.h"
#include "pointreel/version.h"

namespace pointreel {
namespace {

int run(int argc, char** argv) {
  const auto started = std::chrono::steady_clock::now();
  CLI::App app("Pointreel plays point clouds that move.", "pointreel");
  app.formatter(std::make_shared<HelpFormatter>());
  app.set_version_flag("--version", "pointreel " POINTREEL_VERSION, "Print the version and exit");
  app.require_subcommand(1);
  app.set_help_flag("-h,--help", "Print this help and exit");
  const PlayCommand play_command(app);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);
    fmt::print(stderr, "pointreel: {}; see pointreel play --help\n", error.what());
    return 2;
  }
  Result<PlayOptions> options = play_command.options();
  if (!options) {
    fmt::print(stderr, "pointreel: {}\n", options.error().message);
    return 2;
  }
  if (const auto read = play_command.read_settings(*options); !read)
    fmt::print(stderr, "pointreel: {}\n", read.error().message);
  options->started = started;
  return play(*options) ? 0 : 1;
}

}  // namespace
}  // namespace pointreel

int main(int argc, char** argv) {
  pointreel::keep_freed_memory();
  int exit_code = 1;
  try {
    exit_code = pointreel::run(argc, argv);
  } catch (const std::exception& error) {
    fmt::print(stderr, "pointreel: {}\n", error.what());
  }
  return pointreel::finish_output("pointreel", exit_code);
}
