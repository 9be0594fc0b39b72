#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <unistd.h>

#include "codec/cloud_options/cloud_options.h"
#include "codec/live/frame_sender.h"
#include "common/base/try.h"
#include "common/base/words.h"
#include "common/command_line/command.h"
#include "common/command_line/token_option.h"
#include "common/net/url.h"
#include "common/process/print.h"
#include "common/process/stop_signal.h"
#include "server/commands/commands.h"
#include "server/commands/sequence_arguments.h"
#include "server/publish/publisher.h"
#include "server/publish/sound_input.h"

namespace pointreel {
namespace {

namespace fs = std::filesystem;

struct PublishArguments {
  std::string input, to, token, ca_file, topic, sound;
  bool loop = false, follow = false, json = false;
  Reading reading;
  cli::Option token_option;
  SequenceArguments sequence;
};

Result<PublishOptions> make_options(const PublishArguments& arguments) {
  const std::string address = TRY(publishing_address(arguments.to));
  if (std::string fault = fault_of_token(arguments.token_option); !fault.empty()) {
    return fail(ErrorCode::argument, std::move(fault));
  }
  if (arguments.input == "-" && (arguments.loop || arguments.follow)) {
    return fail(ErrorCode::argument, "--loop and --follow need a folder as --input");
  }
  PublishOptions options;
  static_cast<EncodingOptions&>(options) = TRY(arguments.sequence.options());
  if (options.name.empty()) options.name = stream_name_of(arguments.to);
  options.outbox.url = address;
  options.outbox.token = arguments.token;
  options.outbox.ca_file = arguments.ca_file;
  options.sound = arguments.sound;
  options.loop_sound = arguments.loop;
  if (!options.sound.empty()) TRY(check_sound(options.sound));
  return options;
}

/// Opens the input, and takes from its files what the options leave to them.
Result<std::unique_ptr<FrameInput>> open_input(const PublishArguments& arguments,
                                               PublishOptions& options,
                                               const std::stop_token& stop) {
  const LiveClock clock = LiveClock::system();
  if (arguments.input == "-")
    return read_pipe(STDIN_FILENO, clock, arguments.reading, options.max_memory);
  if (arguments.follow)
    return follow_folder(arguments.input, clock, arguments.reading, options.max_memory);
  CloudSequence sequence = TRY(list_cloud_frames(
      {fs::path(arguments.input)}, {.topic = arguments.topic,
                                    .max_memory = options.max_memory,
                                    .reading = arguments.reading,
                                    .stopped = [&stop] { return stop.stop_requested(); }}));
  for (const std::string& line : sequence.warnings) print_error("warning: " + line);
  for (const std::string& guess : sequence.guesses) print_error("read as " + guess);
  if (!arguments.sequence.times_of_files()) sequence.times_us.clear();
  if (!sequence.times_us.empty()) options.fps = std::clamp(sequence.fps, kMinFps, kMaxFps);
  if (arguments.sequence.up_of_files())
    options.up = up_of_frame(sequence.frames.front()).value_or(options.up);
  return play_files(std::move(sequence), options.fps, arguments.loop, clock, options.max_memory);
}

nlohmann::ordered_json to_json(const PublishSummary& summary) {
  return {{"frames", summary.frames},
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
            {"accepted_frames", summary.sent.accepted_frames},
            {"accepted_layers", summary.sent.accepted_layers},
            {"dropped_frames", summary.sent.drops.frames},
            {"dropped_layers", summary.sent.drops.layers},
            {"connections", summary.sent.connections}}},
          {"seconds", summary.seconds}};
}

void print_summary(const PublishSummary& summary) {
  print("{} in {:.1f} s, {} skipped, {} unusable\n", counted(summary.frames, "frame"),
        summary.seconds, summary.skipped, summary.unusable);
  print("  encode  {:.1f} ms per frame ({:.1f} to {:.1f}), {} late, depth {}\n",
        summary.encode_ms.median, summary.encode_ms.min, summary.encode_ms.max, summary.late,
        span_text(summary.depth_min, summary.depth_max));
  print("  sent    {}; {} and {} dropped, not sent in time\n", counted(summary.sent.bytes, "byte"),
        counted(summary.sent.drops.frames, "frame"), counted(summary.sent.drops.layers, "layer"));
  print("  server  accepted {}, {}\n", counted(summary.sent.accepted_frames, "frame"),
        counted(summary.sent.accepted_layers, "layer"));
}

int run_publish(const PublishArguments& arguments) {
  Result<PublishOptions> options = make_options(arguments);
  if (!options) {
    print_error(options.error().message);
    return kExitUsage;
  }
  const StopSignal stop;
  const auto input = open_input(arguments, *options, stop.token());
  if (!input) return failed(input.error());
  PublishListener listener;
  listener.say = [](const std::string& line) { print_error(line); };
  listener.stop = stop.token();
  const Result<PublishSummary> summary = publish(**input, *options, listener);
  if (!summary) return failed(summary.error());
  const bool broke_off = summary->input_error.has_value();
  if (broke_off) print_error(summary->input_error->message);
  if (broke_off && summary->frames == 0) return kExitFailed;
  if (arguments.json) {
    print_json(to_json(*summary));
  } else {
    print_summary(*summary);
  }
  if (summary->sent.accepted_frames > 0) return broke_off ? kExitFailed : kExitOk;
  std::string reason = summary->trouble;
  if (summary->frames == 0 && reason.empty())
    reason = stop.token().stop_requested() ? "interrupted before the server answered"
                                           : "the input gave no frame that could be encoded";
  print_error(fmt::format("{}: nothing arrived there{}{}", without_secrets(arguments.to),
                          reason.empty() ? "" : "; ", reason));
  return kExitFailed;
}

}  // namespace

void add_publish_command(cli::Command app, int& exit_code) {
  const auto arguments = std::make_shared<PublishArguments>();
  PublishArguments& a = *arguments;
  const cli::Command command = app.add_subcommand(
      "publish",
      "Encode frames as they come and send them to a server, until there are no more or SIGINT\n"
      "Players show the stream from ws://HOST:PORT/live/NAME. A lost connection is restored. The "
      "exit code is 1 if the server has accepted no frame.");
  command
      .add_option(
          "-i,--input,FOLDER", a.input,
          "a folder of files of points (PLY, Draco, PCD, LAS, text, OBJ, glTF, numpy, KITTI, "
          "nuScenes, "
          "MCAP) or of depth cameras (depth/*.png or .mkv), or one such file, played at --fps or "
          "at its recorded times; or - for standard input: for each frame its size in four bytes, "
          "little endian, and then a PLY, Draco, PCD, LAS or glTF file")
      .required()
      .type_name("FOLDER|-");
  add_topic_option(command, a.topic);
  add_reading_options(command, a.reading);
  command.add_option("--to", a.to, "where to publish: ws://HOST:PORT/live/NAME, or wss://")
      .required()
      .type_name("URL");
  a.token_option = command.add_option("--token", a.token, "the server's token for publishers")
                       .envname("POINTREEL_TOKEN");
  command
      .add_option("--ca-file", a.ca_file,
                  "for wss://: certificates to trust instead of the system's, in PEM form")
      .check(cli::existing_file())
      .type_name("FILE");
  command
      .add_option(
          "--audio", a.sound,
          "send sound, too: a file that ffmpeg reads, which begins with the first frame, or "
          "microphone (ALSA's default device)")
      .type_name("FILE|microphone");
  const cli::Option loop = command.add_flag("--loop", a.loop, "play the folder again and again");
  command
      .add_flag("--follow", a.follow,
                "instead of playing the folder, send its newest file, and then each file when it "
                "appears")
      .excludes(loop);
  a.sequence.octree.entropy = Entropy::zstd;  // decodes in half the time of context, 25 % larger
  a.sequence.add_to(command, "stream", "default: 80 % of the frame interval", "before");
  command.add_flag("--json", a.json, "print the summary as JSON");
  command.essentials({"--input", "--to", "--token", "--ca-file", "--fps", "--loop", "--follow",
                      "--audio", "--codec", "--quality", "--clean", "--up"});
  command.callback([arguments, &exit_code] { exit_code = run_publish(*arguments); });
}

}  // namespace pointreel
