#include "client/session/stage_setup.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <thread>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "common/base/words.h"
#include "common/net/url.h"
#include "common/process/print.h"

namespace pointreel {

Stage::Options stage_options(const PlayOptions& options) {
  Stage::Options stage;
  stage.size = options.picture_size();
  stage.source.fps = options.fps;
  stage.source.placement = options.placement;
  stage.source.say = [](const std::string& line) { print_error("pointreel", line); };
  stage.source.topic = options.topic;
  stage.source.reading = options.reading;
  stage.source.token = options.token;
  stage.source.ca_file = options.ca_file;
  stage.source.endpoint = options.endpoint;
  stage.source.follow_redirects = options.follow_redirects;
  stage.source.max_memory = stage.prepare.max_memory = options.frame_memory << 20;
  stage.prepare.layers = options.layers;
  stage.prepare = prepare_options(options.settings, stage.prepare);
  stage.reel.loop = options.settings.loop.value_or(!options.offscreen);
  stage.reel.speed = options.speed;
  stage.reel.start_us = start_us(options);
  stage.reel.single_frame = is_single_frame(options);
  // Offscreen and without a loop, no frame is shown twice.
  if (!options.offscreen || stage.reel.loop) stage.reel.cache_bytes = options.cache << 20;
  stage.live.prepare_threads = std::clamp(std::thread::hardware_concurrency(), 1u, 4u);
  return stage;
}

bool is_single_frame(const PlayOptions& options) {
  return options.offscreen && options.at && !options.duration &&
         std::ranges::none_of(options.sources, is_live_address, &Stage::Placed::where);
}

std::chrono::steady_clock::time_point end_of_duration(const PlayOptions& options) {
  using SteadyClock = std::chrono::steady_clock;
  if (!options.duration) return SteadyClock::time_point::max();
  return options.started +
         std::chrono::ceil<SteadyClock::duration>(std::chrono::duration<double>(*options.duration));
}

namespace {

std::string names_of(const std::vector<Stage::Placed>& sources) {
  std::string names;
  for (const Stage::Placed& source : sources)
    names += (names.empty() ? "" : ", ") + without_secrets(source.where);
  return names;
}

}  // namespace

Error nothing_came(const PlayOptions& options) {
  return {fmt::format("{}: no frame came within the {} s of --duration", names_of(options.sources),
                      number_text(*options.duration)),
          ErrorCode::io};
}

std::optional<Error> nothing_shown(const Stage& stage) {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < stage.size(); ++i)
    if (stage.scene()[i].frame == nullptr) names.push_back(stage.where(i));
  if (names.empty()) return std::nullopt;
  return Error{fmt::format("{}: no frame could be shown", fmt::join(names, ", "))};
}

std::uint64_t start_us(const PlayOptions& options) {
  return static_cast<std::uint64_t>(std::llround(options.at.value_or(0.0) * 1'000'000.0));
}

Camera camera_at(const PlayOptions& options, std::uint64_t time_us, const Box& bounds, Up up,
                 glm::ivec2 size) {
  Camera camera;
  camera.up = up;
  const double aspect = static_cast<double>(size.x) / size.y;
  if (options.view) {
    camera.orbit(options.view->yaw, options.view->pitch);
    camera.fit(bounds, aspect);
  } else {
    camera.frame_bounds(bounds, aspect);
  }
  if (options.target) camera.aim_at(*options.target, bounds);
  camera.zoom(1.0 / options.zoom);
  if (options.distance) camera.distance = *options.distance;
  return options.camera_path ? options.camera_path->at(time_us, camera) : camera;
}

Camera first_camera(const PlayOptions& options, const Box& bounds, Up up, glm::ivec2 size) {
  return camera_at(options, start_us(options), bounds, options.settings.up.value_or(up), size);
}

Result<void> check_scalar_field(const Settings& settings, const Stage& stage) {
  const std::string& field = settings.scalar.field;
  const std::vector<std::string> names = stage.scalar_names();
  if (field.empty() || std::ranges::find(names, field) != names.end()) return {};
  for (std::size_t i = 0; i < stage.size(); ++i)
    if (stage.live(i) != nullptr) return {};
  const std::string which =
      stage.size() == 1 ? stage.playback(0).name() + " has" : "the sources have";
  return fail(ErrorCode::argument,
              fmt::format("--color {}: {}", field,
                          names.empty() ? fmt::format("{} no scalar fields", which)
                                        : fmt::format("there is no such scalar field; there are {}",
                                                      fmt::join(names, ", "))));
}

std::optional<FloorGrid> floor_under(const Stage& stage, const Camera& camera) {
  const Box bounds = stage.view_bounds();
  if (bounds.empty()) return std::nullopt;
  return FloorGrid{bounds, camera.up};
}

}  // namespace pointreel
