#include "client/app/play_command.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <map>
#include <numbers>
#include <string_view>
#include <utility>
#include <variant>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "client/options/settings.h"
#include "client/record/open_recorder.h"
#include "client/ui/bindings.h"

namespace pointreel {
namespace {

constexpr int kMaxPictureEdge = 16384;

/// As many numbers as `values` has, with a separator between each two; false if it is anything
/// else, or if one is too large.
template <class Number, std::size_t kCount>
bool parse_numbers(std::string_view text, char separator, std::array<Number, kCount>& values) {
  const char *at = text.data(), *const end = at + text.size();
  for (std::size_t i = 0; i < kCount; ++i) {
    if (i > 0 && (at == end || *at++ != separator)) return false;
    const auto number = std::from_chars(at, end, values[i]);
    if (number.ec != std::errc()) return false;
    at = number.ptr;
  }
  return at == end;
}

Result<glm::ivec2> parse_size(const std::string& text) {
  std::array<int, 2> size{};
  const auto is_edge = [](int edge) { return edge >= 1 && edge <= kMaxPictureEdge; };
  if (!parse_numbers(text, 'x', size) || !is_edge(size[0]) || !is_edge(size[1]))
    return fail(fmt::format("\"{}\" is no size such as 1280x720, at most {} a side", text,
                            kMaxPictureEdge));
  return glm::ivec2(size[0], size[1]);
}

Result<glm::vec3> parse_color(const std::string& text) {
  std::uint32_t color = 0;
  const char *begin = text.data() + (text.starts_with('#') ? 1 : 0),
             *end = text.data() + text.size();
  const auto parsed = std::from_chars(begin, end, color, 16);
  if (parsed.ec != std::errc() || parsed.ptr != end || end - begin != 6)
    return fail(fmt::format("\"{}\" is no colour such as #1c1f24", text));
  return glm::vec3(color >> 16, color >> 8 & 0xff, color & 0xff) / 255.0f;
}

double radians(double degrees) { return degrees * std::numbers::pi / 180.0; }

/// From where to look, or the path of the camera.
using CameraChoice = std::variant<View, CameraPath>;

Result<CameraChoice> parse_camera(const std::string& text) {
  // The poles are as far as the camera goes.
  static const std::map<std::string, View> kNamed = {
      {"front", {0.0, 0.0}},         {"back", {radians(180), 0.0}},
      {"left", {radians(-90), 0.0}}, {"right", {radians(90), 0.0}},
      {"top", {0.0, radians(90)}},   {"bottom", {0.0, radians(-90)}}};
  if (const auto named = kNamed.find(text); named != kNamed.end()) return named->second;
  std::array<double, 2> turn{};
  const bool numbers = parse_numbers(text, ',', turn);
  if (numbers && std::isfinite(turn[0]) && std::abs(turn[1]) <= 90.0)
    return View{radians(turn[0]), radians(turn[1])};
  std::error_code none;
  if (!numbers && std::filesystem::exists(text, none)) {
    auto path = load_camera_path(text);
    if (!path) return tl::unexpected(path.error());
    return *std::move(path);
  }
  return fail(fmt::format(
      "\"{}\" is no view: give front, back, left, right, top, bottom, YAW,PITCH in degrees, "
      "pitch from -90 to 90, or the file of a camera's path",
      text));
}

Result<glm::dvec3> parse_position(const std::string& text) {
  std::array<double, 3> place{};
  const auto is_near = [](double number) { return std::abs(number) <= 1e9; };
  if (!parse_numbers(text, ',', place) || !std::all_of(place.begin(), place.end(), is_near))
    return fail(fmt::format("\"{}\" is no position such as -0.5,0,1.5", text));
  return glm::dvec3(place[0], place[1], place[2]);
}

/// For options: what `parse` has to say, or nothing.
template <class Parse>
CLI::Validator check(Parse parse, const std::string& type) {
  return CLI::Validator(
      [parse](const std::string& text) {
        const auto result = parse(text);
        return result ? std::string() : result.error().message;
      },
      type);
}

/// For numbers; unlike CLI::Range it refuses NaN.
CLI::Validator within(double min, double max) {
  return check(
      [min, max](const std::string& text) -> Result<void> {
        std::array<double, 1> number{};
        if (!parse_numbers(text, ',', number) || !(number[0] >= min && number[0] <= max))
          return fail(fmt::format("\"{}\" is no number from {:g} to {:g}", text, min, max));
        return {};
      },
      fmt::format("{:g} to {:g}", min, max));
}

/// An enum's values by their names; there are `count`, numbered from 0 on.
template <class Enum>
std::map<std::string, Enum> named(int count) {
  std::map<std::string, Enum> all;
  for (int i = 0; i < count; ++i) all.emplace(name(static_cast<Enum>(i)), static_cast<Enum>(i));
  return all;
}

const std::map<std::string, DrawMode>& modes() {
  static const std::map<std::string, DrawMode> kModes = {
      {"surfel", DrawMode::surfel}, {"voxel", DrawMode::voxel}, {"point", DrawMode::point}};
  return kModes;
}

}  // namespace

PlayCommand::PlayCommand(CLI::App& app) {
  mode_ = "surfel";
  instancing_ = name(options_.draw.instancing);
  splatting_ = name(options_.draw.splatting);
  color_ = name(options_.draw.color);
  drafts_ = name(options_.drafts);
  CLI::App& play_command = *app.add_subcommand("play", "Play a reel, in a window or offscreen");
  command_ = &play_command;
  play_command
      .add_option("SOURCE", sources_,
                  "http:// or https:// address of a package, a package's folder, a folder of PLY "
                  "and .drc files, or a live stream: ws:// or wss:// .../live/NAME, or http(s)://"
                  ".../live/NAME/reel.json; several are shown in one scene")
      ->required();
  play_command
      .add_option("--at-position", places_,
                  "Where a source stands, as X,Y,Z in its units; once for each, in their order")
      ->check(check(parse_position, "X,Y,Z"))
      ->allow_extra_args(false);
  play_command
      .add_option("--token", options_.token, "Bearer token for servers that want one to view")
      ->envname("POINTREEL_TOKEN")
      ->type_name("TOKEN");
  play_command
      .add_option("--ca-file", options_.ca_file,
                  "Certificates to trust for https:// and wss:// (default: the system's)")
      ->check(CLI::ExistingFile)
      ->type_name("FILE.pem");
  play_command
      .add_option("--mode", mode_,
                  "What is drawn: surfel (discs oriented by normals), voxel (cubes of the octree, "
                  "as fine as a pixel), point")
      ->check(CLI::IsMember(modes()))
      ->capture_default_str();
  play_command
      .add_option("--instancing", instancing_,
                  "How surfels and voxels are drawn: geometry (shader), uniform (buffers), texture "
                  "(buffer), attribute (of each instance), pull (what can be seen is listed first)")
      ->check(CLI::IsMember(named<Instancing>(kInstancings)))
      ->capture_default_str();
  play_command
      .add_option(
          "--splatting", splatting_,
          "How surfels become a picture: normalized (weighted means), or one of the paper's: "
          "regular, no-depth, two-pass, enlarged, enlarged-shading")
      ->check(CLI::IsMember(named<Splatting>(kSplattings)))
      ->capture_default_str();
  play_command
      .add_option("--delta", options_.delta,
                  "Share of points that may merge in the voxels that are drawn: the paper's 0.05 "
                  "gives nearly every point its own, with wide gaps; 0 keeps all that are distinct")
      ->check(within(0.0, 1.0))
      ->capture_default_str();
  play_command
      .add_option("--layers", options_.layers,
                  "Fetch and decode only so many layers of a package, coarse to fine (default all)")
      ->check(CLI::Range(1, 255))
      ->type_name("N");
  play_command
      .add_option("--speed", options_.speed,
                  "Speed of playback in a window: 0.1 to 4, and -0.1 to -4 backward")
      ->check(CLI::Validator(within(0.1, 4.0)) | within(-4.0, -0.1))
      ->capture_default_str();
  loop_flag_ = play_command.add_flag("--loop,!--no-loop", loop_,
                                     "Begin anew at the end (default in a window) or end there "
                                     "(default offscreen)");
  play_command.add_option("--fps", options_.fps, "Frames a second of a folder of files")
      ->check(within(0.01, 1000.0))
      ->capture_default_str();
  play_command
      .add_option("--up", up_,
                  "The axis that points up, y or z (default: what the package says; y "
                  "for a folder of files)")
      ->check(CLI::IsMember({"y", "z"}));
  play_command
      .add_option("--visibility-scale", options_.draw.scales.visibility,
                  "By how much --splatting normalized enlarges surfels to decide what is visible")
      ->check(within(0.01, 100.0))
      ->capture_default_str();
  play_command
      .add_option("--shading-scale", options_.draw.scales.shading,
                  "By how much it enlarges them to blend their colours")
      ->check(within(0.01, 100.0))
      ->capture_default_str();
  play_command.add_flag("--fill-holes,!--no-fill-holes", options_.draw.fill_holes,
                        "Fill holes from what is around (default): with --splatting normalized, of "
                        "surfaces whose inside would be seen; of voxels, gaps of up to three");
  play_command
      .add_option(
          "--edl", options_.draw.edl,
          "Strength of eye-dome lighting, which darkens what lies behind what is beside it: "
          "1 shows the shape of clouds without normals")
      ->check(within(0.0, 100.0))
      ->capture_default_str();
  play_command
      .add_option(
          "--pixel-size", options_.draw.pixel_size,
          "Nodes of the octree smaller than this many pixels are not divided; 0 draws the leaves")
      ->check(within(0.0, 1000.0))
      ->capture_default_str();
  play_command.add_option("--point-size", options_.draw.point_size, "Edge of points in pixels")
      ->check(within(1.0, 64.0))
      ->capture_default_str();
  play_command
      .add_option("--color", color_,
                  "Where colours come from: colors (the points'), normals (which way they face), "
                  "plain (shape by light alone)")
      ->check(CLI::IsMember(named<ColorSource>(kColorSources)))
      ->capture_default_str();
  play_command.add_flag("--lighting,!--no-lighting", options_.draw.lighting,
                        "A light over the viewer's shoulder (default), or colours as they are");
  play_command
      .add_option("--background", background_, "Colour around what is drawn (default: #1c1f24)")
      ->check(check(parse_color, "#RRGGBB"));
  play_command.add_flag("--floor,!--no-floor", options_.floor,
                        "A grid on the floor, with round steps of 1, 2 or 5 times a power of ten");
  play_command
      .add_option("--offscreen", size_,
                  "Draw pictures of this size without window and display: every frame once, in "
                  "order, as fast as it goes; live streams and several sources in real time")
      ->check(check(parse_size, "WxH"));
  play_command
      .add_option("--at", options_.at,
                  "Begin at this time of the reel; offscreen without --duration: only the frame "
                  "that is shown then")
      ->check(within(0.0, 1e9))
      ->type_name("SECONDS");
  play_command
      .add_option("--duration", options_.duration,
                  "End after so much of the reel (offscreen), or of real time (window)")
      ->check(within(0.0, 1e9))
      ->type_name("SECONDS");
  play_command
      .add_option("--camera,--view", view_,
                  "From where to look: front, back, left, right, top, bottom, or YAW,PITCH in "
                  "degrees (default: the front, slightly from above); or a file with the camera's "
                  "path, such as {\"pointreel_camera_path\": 1, \"keys\": [{\"seconds\": 0, "
                  "\"yaw\": -90, \"pitch\": 10}, {\"seconds\": 2, \"yaw\": 90}]}")
      ->check(check(parse_camera, "VIEW or FILE"));
  play_command.add_option("--screenshot", options_.screenshot, "Write the last picture")
      ->type_name("FILE.png");
  play_command
      .add_option(
          "--drafts", drafts_,
          "When the window may draw pictures with a half or a quarter of the pixels a side, "
          "if there is no time for all: never; moving: while camera or time are moved by "
          "hand; playing: and where frames would be dropped")
      ->check(CLI::IsMember(named<Drafts>(kDrafts)))
      ->capture_default_str();
  play_command
      .add_option("--ui-scale", options_.ui_scale,
                  "Size of the window's interface (default: what the display says)")
      ->check(within(0.5, 4.0))
      ->type_name("FACTOR");
  play_command
      .add_option("--supersample", options_.supersample,
                  "Draw pictures that are written N times as wide and high, and average")
      ->check(CLI::Range(1, 4))
      ->type_name("N")
      ->capture_default_str();
  play_command
      .add_option("--record", options_.record,
                  "Offscreen: write every picture into a video (.mp4, .mkv or .webm; needs "
                  "ffmpeg), each for exactly its time, or into files of its own, where %d, or %04d "
                  "for leading zeros, is its number")
      ->check(check(check_recording_name, "out.mp4 or out-%04d.png"));
  play_command
      .add_option(
          "--json", options_.json,
          "Write a summary: median, 95th percentile and maximum of the times of each stage "
          "over the frames shown; frames shown, refined, reduced (--drafts), dropped and broken; "
          "all bytes fetched; "
          "layers, points, nodes, leaves, depth and elements drawn of the last one. "
          "\"skipped\": layers, levels, attributes and bytes that view and mode did not need, "
          "leaves out of view and below a pixel, voxels that others hide. - is standard output")
      ->type_name("FILE");
  play_command
      .add_option("--config", config_,
                  "Where the window keeps its size and what is changed in it with keys and panels: "
                  "JSON. Options given here win (default: pointreel/player.json in "
                  "$XDG_CONFIG_HOME or ~/.config; offscreen none)")
      ->type_name("FILE");
  play_command.add_flag("--no-config", no_config_, "Neither read nor keep it");
  play_command.footer("Keys in the window:\n" + bindings_help() +
                      "\nExit codes: 0 played to its end or ended by the user, 1 failed, 2 usage");
}

Result<PlayOptions> PlayCommand::options() const {
  PlayOptions options = options_;
  options.draw.mode = modes().at(mode_);
  options.draw.instancing = named<Instancing>(kInstancings).at(instancing_);
  options.draw.splatting = named<Splatting>(kSplattings).at(splatting_);
  options.drafts = named<Drafts>(kDrafts).at(drafts_);
  options.draw.color = named<ColorSource>(kColorSources).at(color_);
  if (!background_.empty()) options.draw.background = *parse_color(background_);
  if (places_.size() > sources_.size())
    return fail(fmt::format("--at-position is given {} times for {} source{}", places_.size(),
                            sources_.size(), sources_.size() > 1 ? "s" : ""));
  for (std::size_t i = 0; i < sources_.size(); ++i) {
    options.sources.push_back({sources_[i], {}});
    if (i < places_.size()) options.sources.back().place = *parse_position(places_[i]);
  }
  if (loop_flag_->count() > 0) options.loop = loop_;
  if (!up_.empty()) options.up = up_[0];
  options.offscreen = !size_.empty();
  if (options.offscreen) options.size = *parse_size(size_);
  if (!view_.empty()) {
    auto camera = parse_camera(view_);
    if (!camera) return tl::unexpected(camera.error());
    if (const View* view = std::get_if<View>(&*camera)) options.view = *view;
    if (CameraPath* path = std::get_if<CameraPath>(&*camera))
      options.camera_path = std::move(*path);
  }
  if (!options.record.empty() && !options.offscreen) return fail("--record needs --offscreen WxH");
  return options;
}

Result<void> PlayCommand::read_settings(PlayOptions& options) const {
  options.settings_file.clear();
  if (no_config_) return {};
  std::filesystem::path file = config_;
  if (config_.empty() && !options.offscreen) file = default_settings_file();
  if (file.empty()) return {};
  const glm::ivec2 size = options.size;
  const auto given = [this](std::string_view name) {
    const CLI::Option* option = command_->get_option_no_throw(fmt::format("--{}", name));
    return option != nullptr && option->count() > 0;
  };
  const auto read = pointreel::read_settings(file, given, options);
  if (!read) return read;
  if (options.offscreen) options.size = size;
  options.settings_file = file.string();
  return {};
}

}  // namespace pointreel
