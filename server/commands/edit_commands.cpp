#include <cmath>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "common/base/words.h"
#include "common/command_line/command.h"
#include "common/process/stop_signal.h"
#include "server/commands/commands.h"
#include "server/commands/package_access.h"
#include "server/edit/cut_package.h"
#include "server/edit/join_packages.h"
#include "server/pack/frame_numbers.h"

namespace pointreel {
namespace {

std::string sound_text(const AudioFile& audio) {
  return number_text(static_cast<double>(audio.samples) / kAudioRate) + " s of sound";
}

struct CutArguments {
  std::string reel, frames;
  std::optional<double> from, until, to;  ///< `to`: an earlier name of `until`
  CutOptions options;
  PackageAccess access;
};

int run_cut(CutArguments arguments) {
  if (arguments.to) {
    print_error("cut: --to is now called --until");
    arguments.until = arguments.to;
  }
  CutOptions& options = arguments.options;
  const auto microseconds = [](double seconds) {
    return static_cast<std::uint64_t>(std::llround(seconds * 1e6));
  };
  if (!arguments.frames.empty()) {
    const auto range = parse_frame_numbers(arguments.frames);
    if (!range) {
      print_error(fault_of_frame_numbers(arguments.frames));
      return kExitUsage;
    }
    options.frames = CutRange{range->first, range->second};
  } else if (!arguments.from && !arguments.until) {
    print_error("cut: give the part to keep, by --from and --until or by --frames");
    return kExitUsage;
  }
  if (arguments.from) options.from_us = microseconds(*arguments.from);
  if (arguments.until) options.to_us = microseconds(*arguments.until);
  if (options.to_us <= options.from_us) {
    print_error("cut: --until must be later than --from, and later than 0");
    return kExitUsage;
  }
  const StopSignal stop;
  const Result<PackageFiles> files = arguments.access.open(arguments.reel, stop.token());
  if (!files) return failed_to_open(files.error());
  options.input = *files;
  const Result<CutReport> cut = cut_package(options, stop.token());
  if (!cut) return failed_to_open(cut.error());
  print("{}: frames {} of {}, {}, {}{}\n", options.output.string(),
        span_text(cut->frames.first, cut->frames.last), files->shown(),
        counted(cut->segments, "segment"), counted(cut->bytes, "byte"),
        cut->audio ? ", " + sound_text(*cut->audio) : "");
  return kExitOk;
}

struct JoinArguments {
  std::vector<std::string> reels;
  JoinOptions options;
  PackageAccess access;
};

int run_join_packages(JoinArguments arguments) {
  JoinOptions& options = arguments.options;
  const StopSignal stop;
  for (const std::string& reel : arguments.reels) {
    Result<PackageFiles> files = arguments.access.open(reel, stop.token());
    if (!files) return failed_to_open(files.error());
    options.inputs.push_back(std::move(*files));
  }
  const Result<JoinedPackages> joined = join_packages(options, stop.token());
  if (!joined) return failed_to_open(joined.error());
  for (const std::size_t silent : joined->silent)
    print_error(options.inputs[silent].shown() + ": has no sound, so its part is silent");
  print("{}: {}, {}, {}{}\n", options.output.string(), counted(joined->frames, "frame"),
        counted(joined->segments, "segment"), counted(joined->bytes, "byte"),
        joined->audio ? ", " + sound_text(*joined->audio) : "");
  return kExitOk;
}

/// `options`: CutOptions or JoinOptions.
template <class Options>
void add_new_package(cli::Command command, const char* names, Options& options) {
  command.add_option(names, options.output, "the folder of the new package")
      .required()
      .type_name("REEL");
  command.add_flag("--force", options.force, "replace a package that is already there");
  command.add_option("--name", options.name, "a display name (default: that of the folder)");
}

void add_cut_command(cli::Command app, int& exit_code) {
  const auto a = std::make_shared<CutArguments>();
  const cli::Command command = app.add_subcommand(
      "cut",
      "Make a package of a part of another one, without encoding anything again\n"
      "Frames are cut exactly, and sound is cut with them.");
  command.add_option("-i,--input,INPUT", a->reel, "the folder or the address of the package")
      .required()
      .type_name("REEL");
  add_new_package(command, "-o,--output,OUTPUT", a->options);
  const cli::Option from =
      command
          .add_option("--from", a->from,
                      "keep what is shown from this time of the reel on (default: its beginning)")
          .check(cli::number_within(0.0, 1e9))
          .type_name("SECONDS");
  const cli::Option until =
      command
          .add_option("--until", a->until,
                      "keep what is shown before this time of the reel (default: its end)")
          .check(cli::number_within(0.0, 1e9))
          .type_name("SECONDS");
  const cli::Option to = command.add_option("--to", a->to, "the earlier name of --until")
                             .check(cli::number_within(0.0, 1e9))
                             .type_name("SECONDS")
                             .group("")
                             .excludes(until);
  command
      .add_option("--frames", a->frames,
                  "instead of times: keep frames A to B, including both, or only frame A, "
                  "numbered from 0 among those that are shown")
      .type_name("A-B")
      .excludes(from)
      .excludes(until)
      .excludes(to);
  a->access.add_to(command);
  command.callback([a, &exit_code] { exit_code = run_cut(*a); });
}

void add_join_command(cli::Command app, int& exit_code) {
  const auto a = std::make_shared<JoinArguments>();
  const cli::Command command = app.add_subcommand(
      "join",
      "Make one package of several, such as recordings of one stream, without encoding anything "
      "again\n"
      "Each begins when the one before it is over. They must have the same codec, entropy coder, "
      "layers, up axis, colours, normals and scalar fields, and about the same frame rate. Sound "
      "is joined, too. "
      "(pack join is for parts of a plan.)");
  command
      .add_option("INPUTS", a->reels,
                  "the folders or the addresses of the packages, in the order in which they are "
                  "shown")
      .required()
      .type_name("");
  add_new_package(command, "-o,--output", a->options);
  a->access.add_to(command);
  command.callback([a, &exit_code] { exit_code = run_join_packages(*a); });
}

}  // namespace

void add_edit_commands(cli::Command app, int& exit_code) {
  add_cut_command(app, exit_code);
  add_join_command(app, exit_code);
}

}  // namespace pointreel
