#include "client/app/play_command.h"

#include <algorithm>
#include <filesystem>
#include <system_error>
#include <utility>
#include <variant>
#include <vector>

#include <fmt/format.h>

#include "client/app/arguments.h"
#include "client/options/option_table.h"
#include "client/options/option_text.h"
#include "client/options/settings_file.h"
#include "client/playback/clock.h"
#include "client/record/open_recorder.h"
#include "client/scene/radiance_picture.h"
#include "client/ui/bindings.h"
#include "codec/cloud_options/cloud_options.h"
#include "common/base/try.h"
#include "common/command_line/token_option.h"
#include "common/net/server_tokens.h"
#include "common/net/url.h"

namespace pointreel {
namespace {

Result<void> check_folder_of(const std::string& file) {
  const std::filesystem::path folder = std::filesystem::path(file).parent_path();
  std::error_code error;
  if (folder.empty() || std::filesystem::is_directory(folder, error)) return {};
  return fail(ErrorCode::argument,
              fmt::format("{}: there is no folder {}; make it first", file, folder.string()));
}

constexpr Range kPictureSide{1, kMaxImageSide}, kFps{0.01, 1000.0}, kSeconds{0.0, 1e9},
    kZoom{0.01, 1000.0}, kDistance{1e-9, 1e12}, kForward{kMinSpeed, kMaxSpeed},
    kBackward{-kMaxSpeed, -kMinSpeed};
constexpr int kMaxLayers = 255, kMaxSupersample = 4, kMostCache = 1 << 20;

cli::Check within(const Range& range) {
  return cli::parsed_by([range](const std::string& text) { return parse_number(text, range); });
}

Result<double> parse_speed(const std::string& text) {
  if (const auto backward = parse_number(text, kBackward)) return backward;
  const auto forward = parse_number(text, kForward);
  if (forward) return forward;
  return fail(ErrorCode::argument, fmt::format("{} or {:g} to {:g}", forward.error().message,
                                               kBackward.min, kBackward.max));
}

Result<Up> parse_up_name(const std::string& text) {
  const auto up = parse_up(text);
  if (!up) return fail(ErrorCode::argument, fmt::format("\"{}\" is not one of {}", text, kUpNames));
  return *up;
}

/// What the option is for, what it accepts, and its default.
std::string description(const Option& option) {
  const std::string value = value_text(option, {});
  if (std::holds_alternative<Option::Flag>(option.value)) return std::string(option.help);
  if (std::holds_alternative<Option::Color>(option.value))
    return fmt::format("{} (default {})", option.help, value);
  // The rest of these comes from the check and the default.
  if (std::holds_alternative<Option::Choice>(option.value)) return std::string(option.help);
  return fmt::format("{} ({}; default {})", option.help, accepted_values(option), value);
}

const char* type_name(const Option& option) {
  if (std::holds_alternative<Option::Number>(option.value)) return "NUMBER";
  return std::holds_alternative<Option::Choice>(option.value) ? "NAME" : "#RRGGBB";
}

/// set_from_text, but --color may also name a scalar field.
Result<void> set_text(const Option& option, const std::string& text, Settings& settings) {
  return option.name == "color" ? set_color(text, settings) : set_from_text(option, text, settings);
}

/// Adds an option of the table, or its earlier name.
cli::Option add(cli::Command command, const Option& option, std::string_view name) {
  const std::string full = command_line_name(name);
  if (std::holds_alternative<Option::Flag>(option.value))
    return command.add_flag(full + ",!--no-" + full.substr(2));
  cli::Check check = cli::parsed_by([&option](const std::string& text) {
    Settings ignored;
    return set_text(option, text, ignored);
  });
  const cli::Option added = command.add_option(full).type_name(type_name(option));
  if (const auto* choice = std::get_if<Option::Choice>(&option.value)) {
    // --help, manual pages and completions take the names from here.
    check.accepts = fmt::format("{{{}}}", fmt::join(choice->names, ","));
    added.default_str(value_text(option, {}));
  }
  return added.check(check);
}

}  // namespace

PlayCommand::PlayCommand(cli::Command app) {
  const cli::Command command =
      app.add_subcommand("play", "Play point clouds in a window or offscreen");
  command_ = command;
  add_sources(command);
  add_playback(command);
  add_settings(command);
  add_window(command);
  add_output(command);
  command.essentials({"--camera", "--target", "--zoom", "--mode", "--light", "--background", "--up",
                      "--at", "--speed", "--loop", "--token", "--ca-file", "--offscreen",
                      "--screenshot", "--record"});
  command.footer("Keys and mouse in the window:\n" + bindings_help() +
                 "\nExit status: 0 if it played to the end or was ended by the user, 1 if it "
                 "failed,\n2 if the command line is wrong.");
}

void PlayCommand::add_sources(cli::Command command) {
  command
      .add_option(
          "SOURCE", sources_,
          "What to play: a package, as a folder or an http://, https:// or s3:// address; "
          "a folder of files of points (PLY, Draco, PCD, LAS, text, OBJ, glTF, numpy, KITTI, "
          "nuScenes, MCAP) or of depth cameras (depth/*.png or .mkv, with intrinsics in "
          "JSON), or one such file; or a live stream, as ws://.../live/NAME, wss:// "
          "or http(s)://.../live/NAME/reel.json. Several sources are shown in one scene")
      .required()
      .type_name("");
  const std::string group = "Sources";
  command
      .add_option("--at-position", positions_,
                  "Position of a source in the scene, in its own units; may be given once for "
                  "each source, in their order")
      .check(cli::parsed_by(parse_position))
      .type_name("X,Y,Z")
      .allow_extra_args(false)
      .group(group);
  token_ = command
               .add_option("--token", options_.token,
                           "Bearer token for servers that ask viewers for one; may be given in the "
                           "environment as POINTREEL_TOKEN")
               .envname("POINTREEL_TOKEN")
               .type_name("TOKEN")
               .group(group);
  command
      .add_option("--token-file", token_file_,
                  "Tokens of several servers: in each line the address of one, such as wss://HOST, "
                  "and its token; others get --token")
      .check(cli::existing_file())
      .type_name("FILE")
      .group(group);
  command
      .add_option("--ca-file", options_.ca_file,
                  "Certificates to trust for https:// and wss:// (default: those of the system)")
      .check(cli::existing_file())
      .type_name("FILE.pem")
      .group(group);
  command
      .add_option("--endpoint", options_.endpoint,
                  "The object store that s3:// means, such as http://127.0.0.1:9000 (default: "
                  "AWS_ENDPOINT_URL, or Amazon's). Its keys are read from the environment or from "
                  "~/.aws, as Amazon's programs do")
      .type_name("URL")
      .group(group);
  command
      .add_flag("--follow-redirects", options_.follow_redirects,
                "Follow redirects to other hosts, too. Those from https:// to http:// are never "
                "followed")
      .group(group);
  command
      .add_option("--layers", options_.layers,
                  "Fetch and decode only this many layers of a package, from coarse to fine "
                  "(default: as many as the view needs)")
      .check(cli::range(1, kMaxLayers))
      .type_name("N")
      .group(group);
  add_frame_memory_option(command, options_.frame_memory).group(group);
  command
      .add_option("--cache", options_.cache,
                  "The memory for decoded frames of a package or folder that are kept after they "
                  "were shown, in MiB, so that a loop that fits is decoded once; 0: none")
      .check(cli::range(0, kMostCache))
      .capture_default_str()
      .type_name("MIB")
      .group(group);
  command
      .add_option(
          "--fps", options_.fps,
          "Frames per second of a folder of files (default 30, or the times of a recording)")
      .check(within(kFps))
      .type_name("NUMBER")
      .group(group);
  command
      .add_option("--up", up_,
                  "The axis that points up: x, -x, y, -y, z or -z (default: what the package says; "
                  "for files, z in LAS, KITTI, nuScenes and MCAP files, and otherwise y)")
      .check(cli::parsed_by(parse_up_name))
      .type_name("AXIS")
      .group(group);
  add_topic_option(command, options_.topic).group(group);
  for (const cli::Option option : add_reading_options(command, options_.reading))
    option.group(group);
  for (const cli::Option option : add_placement_options(command, options_.placement))
    option.group(group);
}

void PlayCommand::add_playback(cli::Command command) {
  const std::string group = "Playback";
  command
      .add_option("--at", options_.at,
                  "Begin at this time of the reel. Offscreen and without --duration, show only "
                  "the picture at this time")
      .check(within(kSeconds))
      .type_name("SECONDS")
      .group(group);
  command
      .add_option("--duration", options_.duration,
                  "Stop this long after the start of the program. Offscreen, a package or a folder "
                  "of files stops after this much of its own time, or, if nothing of it comes over "
                  "the network, this long after the start of the program")
      .check(within(kSeconds))
      .type_name("SECONDS")
      .group(group);
  command
      .add_option(
          "--speed", options_.speed,
          fmt::format("Speed in a window: {:g} to {:g}, or {:g} to {:g} to play backward "
                      "(default {:g})",
                      kForward.min, kForward.max, kBackward.max, kBackward.min, options_.speed))
      .check(cli::parsed_by(parse_speed))
      .type_name("NUMBER")
      .group(group);
  command
      .add_flag_callback(
          "--no-audio", [this] { options_.audio = false; },
          "Neither play nor record sound, and do not fetch it")
      .group("Sound");
  command
      .add_option("--audio-device", options_.audio_device,
                  "The device of ALSA that plays sound, such as those that aplay -L lists; or "
                  "null, which nobody hears")
      .capture_default_str()
      .type_name("NAME")
      .group("Sound");
  command
      .add_option("--camera,--view", camera_,
                  "Where to look from: front, back, left, right, top, bottom, or YAW,PITCH in "
                  "degrees (default: the front, slightly from above). Or the name of a file with "
                  "a path for the camera, such as {\"pointreel_camera_path\": 1, \"keys\": "
                  "[{\"seconds\": 0, \"yaw\": -90, \"pitch\": 10}, {\"seconds\": 2, \"yaw\": 90}]}")
      .check(cli::parsed_by(parse_camera))
      .type_name("VIEW")
      .group(group);
  command
      .add_option(
          "--target", target_,
          "What is in the middle of the picture: a point, or feet, middle or head, which are "
          "heights of the scene (default: middle)")
      .check(cli::parsed_by(parse_target))
      .type_name("X,Y,Z|NAME")
      .group(group);
  const cli::Option zoom =
      command
          .add_option(
              "--zoom", options_.zoom,
              "How many times larger the scene is shown than as a whole, such as 4 for a close "
              "view with --target")
          .check(within(kZoom))
          .type_name("NUMBER")
          .group(group);
  command
      .add_option("--distance", options_.distance,
                  "How far the eye is from what is in the middle of the picture, in the units of "
                  "the points, such as 0.3 with --target head; instead of --zoom")
      .check(within(kDistance))
      .excludes(zoom)
      .type_name("NUMBER")
      .group(group);
}

void PlayCommand::add_settings(cli::Command command) {
  command
      .add_option("--environment", environment_,
                  "A picture of the light all around, as an equirectangular Radiance file; sets "
                  "--light environment unless --light is given, too")
      .type_name("FILE.hdr")
      .group("Drawing");
  command
      .add_option("--color-range", color_range_,
                  "With --color and a scalar field: the values that the ends of the colour ramp "
                  "stand for (default: the least and the largest of the source)")
      .check(cli::parsed_by(parse_interval))
      .type_name("A,B")
      .group("Drawing");
  for (const Option& option : option_table()) {
    if (option.help.empty()) continue;
    const cli::Option added = add(command, option, option.name)
                                  .description(description(option))
                                  .group(std::string(option.group));
    // Without a group it is not in --help.
    given_.emplace_back(&option, added);
    if (option.old_name.empty()) continue;
    given_.emplace_back(&option, add(command, option, option.old_name).group("").excludes(added));
  }
}

void PlayCommand::add_window(cli::Command command) {
  const std::string group = "Window";
  command
      .add_option("--config", config_,
                  "The JSON file in which the window keeps its size and what you change with keys "
                  "and panels. Options on the command line take precedence over it (default: "
                  "pointreel/player.json in $XDG_CONFIG_HOME or ~/.config; offscreen: none)")
      .type_name("FILE")
      .group(group);
  command.add_flag("--no-config", no_config_, "Neither read nor write such a file").group(group);
}

void PlayCommand::add_output(cli::Command command) {
  const std::string group = "Output";
  command
      .add_option("--offscreen", offscreen_,
                  "Draw pictures of this size without a window or a display: every frame once, in "
                  "order and as fast as possible; live streams and several sources in real time")
      .check(cli::parsed_by([](const std::string& text) { return parse_size(text, kPictureSide); }))
      .type_name("WIDTHxHEIGHT")
      .group(group);
  command.add_option("--screenshot", options_.screenshot, "Write the last picture, as PNG")
      .check(cli::parsed_by(check_picture_name))
      .type_name("FILE.png")
      .group(group);
  command
      .add_option("--record", options_.record,
                  "Offscreen: write all pictures. Into a video, if the name ends in .mp4, .mkv or "
                  ".webm (needs ffmpeg), with the exact time of each picture. Into one file for "
                  "each picture, if the name has a %d, or %04d with leading zeros, for its number")
      .check(cli::parsed_by(check_recording_name))
      .type_name("FILE")
      .group(group);
  command
      .add_option("--supersample", options_.supersample,
                  "Draw pictures that are written N times as wide and high, and average them down")
      .check(cli::range(1, kMaxSupersample))
      .capture_default_str()
      .type_name("N")
      .group(group);
  command
      .add_option("--json", options_.json,
                  "Write a summary as JSON; - is standard output. It has the median, 95th "
                  "percentile and maximum time of each step over all frames shown; how many frames "
                  "were shown, refined, reduced (see --drafts), dropped and broken; the bytes "
                  "fetched; and of the last frame the layers, points, nodes, leaves, depth and "
                  "elements drawn. \"skipped\" tells what the view and the mode did not need: "
                  "layers, levels, attributes and bytes, leaves out of view or below a pixel, and "
                  "voxels hidden by others")
      .type_name("FILE")
      .group(group);
}

/// Sets what the command line gives of the settings.
Result<void> PlayCommand::set_given(Settings& settings) const {
  for (const auto& [option, given] : given_) {
    if (given.count() > 0) TRY(set_text(*option, given.value(), settings));
  }
  if (!environment_.empty() && command_.count("--light") == 0)
    settings.draw.light = Light::environment;
  if (!color_range_.empty()) {
    if (settings.scalar.field.empty())
      return fail(ErrorCode::argument, "--color-range needs --color with a scalar field");
    settings.scalar.range = TRY(parse_interval(color_range_));
  }
  if (!up_.empty()) settings.up = TRY(parse_up_name(up_));
  return {};
}

Result<PlayOptions> PlayCommand::options() const {
  PlayOptions options = options_;
  TRY(set_given(options.settings));
  if (!environment_.empty())
    options.settings.draw.environment =
        std::make_shared<const EnvironmentMap>(TRY(load_environment(environment_)));
  else if (options.settings.draw.light == Light::environment)
    return fail(ErrorCode::argument, "--light environment needs --environment FILE.hdr");
  if (command_.count("--instancing") > 0 && options.settings.renderer == RendererChoice::software)
    return fail(ErrorCode::argument,
                "--instancing is a way of OpenGL and does nothing with --renderer software");
  if (std::string fault = fault_of_token(token_); !fault.empty())
    return fail(ErrorCode::argument, std::move(fault));
  if (positions_.size() > sources_.size())
    return fail(ErrorCode::argument,
                fmt::format("--at-position is given {} times for {} source{}", positions_.size(),
                            sources_.size(), sources_.size() > 1 ? "s" : ""));
  ServerTokens tokens;
  if (!token_file_.empty()) tokens = TRY(at_place("--token-file", ServerTokens::read(token_file_)));
  for (std::size_t i = 0; i < sources_.size(); ++i) {
    options.sources.push_back({sources_[i], {}});
    if (const std::string* token = tokens.of(sources_[i])) options.sources.back().token = *token;
    if (i < positions_.size()) options.sources.back().place = TRY(parse_position(positions_[i]));
  }
  if (!offscreen_.empty()) options.offscreen = TRY(parse_size(offscreen_, kPictureSide));
  if (!camera_.empty()) {
    CameraArgument camera = TRY(parse_camera(camera_));
    if (const View* view = std::get_if<View>(&camera)) options.view = *view;
    if (CameraPath* path = std::get_if<CameraPath>(&camera)) options.camera_path = std::move(*path);
  }
  if (!target_.empty()) options.target = TRY(parse_target(target_));
  if (!options.record.empty() && !options.offscreen)
    return fail(ErrorCode::argument, "--record needs --offscreen WIDTHxHEIGHT");
  const auto live = std::ranges::find_if(options.sources, is_live_address, &Stage::Placed::where);
  if (options.offscreen && options.at && !options.duration && live != options.sources.end())
    return fail(ErrorCode::argument,
                fmt::format("--at: {} is live, where one picture of a time cannot be asked for; "
                            "give --duration as well",
                            without_secrets(live->where)));
  // These files are written at the end, which may be hours away.
  std::vector<std::pair<const char*, std::string>> files;
  if (options.camera_path) files.emplace_back("--camera", camera_);
  for (const auto& [option, file] : {std::pair{"--screenshot", &options.screenshot},
                                     {"--record", &options.record},
                                     {"--json", &options.json}}) {
    TRY(check_folder_of(*file));
    if (file->empty() || *file == "-") continue;
    for (const auto& [other, taken] : files) {
      std::error_code ignored;
      if (*file == taken || std::filesystem::equivalent(*file, taken, ignored))
        return fail(ErrorCode::argument,
                    fmt::format("{} {}: is the file of {}", option, *file, other));
    }
    files.emplace_back(option, *file);
  }
  return options;
}

Result<void> PlayCommand::read_settings(PlayOptions& options) const {
  options.settings_file.clear();
  if (no_config_) return {};
  std::filesystem::path file = config_;
  if (config_.empty() && !options.offscreen) file = default_settings_file();
  if (file.empty()) return {};
  Settings settings;
  TRY(pointreel::read_settings(file, settings));
  settings.draw.environment = options.settings.draw.environment;
  TRY(set_given(settings));
  options.settings = settings;
  options.settings_file = file.string();
  return {};
}

}  // namespace pointreel
