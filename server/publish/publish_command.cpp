#include "server/publish/publish_command.h"

#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <unistd.h>

#include "common/base/stop_signal.h"
#include "pointreel/draco.h"
#include "server/pack/commands.h"
#include "server/pack/encode_arguments.h"
#include "server/publish/publisher.h"

namespace pointreel {
namespace {

namespace fs = std::filesystem;

/// Of the time between two frames, where --frame-time says nothing else.
constexpr double kBudgetShare = 0.8;

struct PublishArguments {
  std::string input, to, token, ca_file;
  double frame_time_ms = 0.0;
  bool loop = false, follow = false, json = false;
  SequenceArguments sequence;
  EncodeArguments encode;
  CLI::Option* frame_time_option = nullptr;
};

/// The name of the stream, where the address ends in one.
std::string stream_name(const std::string& url) { return url.substr(url.rfind('/') + 1); }

Result<PublishOptions> make_options(const PublishArguments& arguments) {
  PublishOptions options;
  if (const auto url = parse_websocket_url(arguments.to); !url) return tl::unexpected(url.error());
  if (arguments.to.find_first_of("?#") != std::string::npos ||
      !is_stream_name(stream_name(arguments.to))) {
    return fail(arguments.to + ": does not end in the stream's name, as in ws://HOST:8090/live/me");
  }
  const SequenceArguments& sequence = arguments.sequence;
  if (const auto sound = sequence.check(); !sound) return tl::unexpected(sound.error());
  const bool pipe = arguments.input == "-";
  if (pipe && (arguments.loop || arguments.follow)) {
    return fail("--loop and --follow belong to folders");
  }
  if (arguments.loop && arguments.follow) return fail("--loop and --follow exclude each other");
  const Result<EncodeOptions> encode = arguments.encode.options();
  if (!encode) return tl::unexpected(encode.error());
  options.encode = *encode;
  const Result<std::optional<double>> voxel = arguments.encode.voxel();
  if (!voxel) return tl::unexpected(voxel.error());
  options.voxel = *voxel;
  options.name = sequence.name.empty() ? stream_name(arguments.to) : sequence.name;
  options.fps = sequence.fps;
  options.up = sequence.up.front();
  options.threads = sequence.threads;
  options.frame_time_ms = kBudgetShare * 1000.0 / sequence.fps;
  if (arguments.frame_time_option->count() > 0) {
    if (!(arguments.frame_time_ms > 0.0)) return fail("--frame-time must be above 0");
    options.frame_time_ms = arguments.frame_time_ms;
  }
  // The server tells publishers from viewers by it.
  options.outbox.url = arguments.to + "?publish";
  options.outbox.token = arguments.token;
  options.outbox.ca_file = arguments.ca_file;
  return options;
}

Result<std::unique_ptr<FrameInput>> open_input(const PublishArguments& arguments) {
  if (arguments.input == "-") return read_pipe(STDIN_FILENO);
  if (arguments.follow) return follow_folder(arguments.input);
  auto files = list_cloud_files({fs::path(arguments.input)});
  if (!files) return tl::unexpected(files.error());
  return play_files(std::move(*files), arguments.sequence.fps, arguments.loop);
}

void print_json(const PublishSummary& summary) {
  const nlohmann::ordered_json json = {
      {"frames", summary.frames},
      {"skipped", summary.skipped},
      {"unusable", summary.unusable},
      {"late", summary.late},
      {"encode_ms",
       {{"median", summary.encode_ms.median},
        {"min", summary.encode_ms.min},
        {"max", summary.encode_ms.max}}},
      {"depth", {{"min", summary.depth_min}, {"max", summary.depth_max}}},
      {"lowered", summary.lowered},
      {"sent",
       {{"layers", summary.sent.layers},
        {"bytes", summary.sent.bytes},
        {"dropped_frames", summary.sent.drops.frames},
        {"dropped_layers", summary.sent.drops.layers},
        {"connections", summary.sent.connections}}},
      {"seconds", summary.seconds}};
  fmt::print("{}\n", json.dump(2));
}

void print_summary(const PublishSummary& summary) {
  fmt::print("{} frames in {:.1f} s, {} skipped, {} unusable\n", summary.frames, summary.seconds,
             summary.skipped, summary.unusable);
  fmt::print("  encode  {:.1f} ms a frame ({:.1f} to {:.1f}), {} late, depth {} to {}\n",
             summary.encode_ms.median, summary.encode_ms.min, summary.encode_ms.max, summary.late,
             summary.depth_min, summary.depth_max);
  fmt::print("  sent    {} bytes; {} frames and {} layers did not fit the link\n",
             summary.sent.bytes, summary.sent.drops.frames, summary.sent.drops.layers);
}

int run_publish(const PublishArguments& arguments) {
  const Result<PublishOptions> options = make_options(arguments);
  if (!options) {
    print_error(options.error().message);
    return kExitUsage;
  }
  const StopSignal stop;
  const auto input = open_input(arguments);
  if (!input) {
    print_error(input.error().message);
    return kExitFailed;
  }
  PublishListener listener;
  listener.say = print_error;
  listener.stop = stop.token();
  const Result<PublishSummary> summary = publish(**input, *options, listener);
  if (!summary) {
    print_error(summary.error().message);
    return kExitFailed;
  }
  if (arguments.json) {
    print_json(*summary);
  } else {
    print_summary(*summary);
  }
  return kExitOk;
}

}  // namespace

void add_publish_command(CLI::App& app, int& exit_code) {
  const auto arguments = std::make_shared<PublishArguments>();
  PublishArguments& a = *arguments;
  CLI::App* command = app.add_subcommand(
      "publish",
      "encode frames as they come and send them to a server, until there are no more or SIGINT\n"
      "Players show them from ws://HOST:PORT/live/NAME. A connection that is lost is made again.");
  command
      ->add_option("-i,--input", a.input,
                   "a folder of .ply or .drc files, played at --fps; or - for standard input: for "
                   "each frame its size, four bytes, little endian, then a PLY or Draco file")
      ->required()
      ->type_name("DIR|-");
  command->add_option("--to", a.to, "where to: ws://HOST:PORT/live/NAME, or wss://")
      ->required()
      ->type_name("URL");
  command->add_option("--token", a.token, "the server's token for publishers")
      ->envname("POINTREEL_TOKEN");
  command->add_option("--ca-file", a.ca_file,
                      "certificates to trust with wss://, in PEM, instead of the system's");
  command->add_flag("--loop", a.loop, "play the folder again and again");
  command->add_flag("--follow", a.follow,
                    "instead: the newest file of the folder, then each that is put there");
  a.frame_time_option =
      command
          ->add_option("--frame-time", a.frame_time_ms,
                       "milliseconds to encode a frame in: depth is lowered rather than falling "
                       "behind (default: 0.8 of the time between two frames)")
          ->type_name("MS");
  a.sequence.add_to(*command, "for people, instead of the stream's name");
  command->add_flag("--json", a.json, "the summary as JSON");
  a.encode.entropy = "zstd";  // decodes in half the time of context, at a quarter more bytes
  a.encode.add_to(*command);
  command->callback([arguments, &exit_code] { exit_code = run_publish(*arguments); });
}

}  // namespace pointreel
