#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <string_view>
#include <vector>

#include "client/app/play_command.h"
#include "client/app/player.h"
#include "client/playback/opening.h"
#include "common/command_line/command.h"
#include "common/process/print.h"
#include "common/process/run_main.h"

namespace pointreel {
namespace {

/// The command line, with `play` where it is left out.
std::vector<const char*> with_command(int argc, char** argv) {
  std::vector<const char*> line(argv, argv + argc);
  if (argc < 2) return line;
  const std::string_view first = argv[1];
  const bool complete = first == "play" || first == "-h" || first == "--help" ||
                        first == "--version" || first.starts_with("--write-manuals");
  if (!complete) line.insert(line.begin() + 1, "play");
  return line;
}

int run(int argc, char** argv) {
  const auto started = std::chrono::steady_clock::now();
  cli::Program app("Pointreel plays point clouds that move.", "pointreel");
  app.require_subcommand(1, 1);
  const PlayCommand play_command(app);
  app.add_common_options();
  const std::vector<const char*> line = with_command(argc, argv);
  if (const auto status = app.parse(static_cast<int>(line.size()), line.data())) return *status;
  Result<PlayOptions> options = play_command.options();
  if (!options) {
    print_error("pointreel", options.error().message);
    return 2;
  }
  if (const auto read = play_command.read_settings(*options); !read)
    print_error("pointreel", read.error().message);
  options->started = started;
  const int status = play(*options) ? 0 : 1;
  // A lookup or a decoder that could not be interrupted ends with the process. It must not see how
  // the things that it uses are destroyed one by one.
  if (unfinished()) {
    std::fflush(nullptr);
    std::_Exit(status);
  }
  return status;
}

}  // namespace
}  // namespace pointreel

int main(int argc, char** argv) {
  return pointreel::run_main("pointreel", [&] { return pointreel::run(argc, argv); });
}
