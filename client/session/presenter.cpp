#include "client/session/presenter.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <fstream>
#include <thread>
#include <utility>

#include "client/render/gl_context.h"
#include "common/base/unix_time.h"

namespace pointreel {

bool single_frame(const PlayOptions& options) {
  return options.offscreen && options.at && !options.duration && options.sources.size() == 1;
}

Stage::Options stage_options(const PlayOptions& options) {
  Stage::Options stage;
  stage.size = options.size;
  stage.source.fps = options.fps;
  stage.source.up = options.up.value_or('y');
  stage.source.token = options.token;
  stage.source.ca_file = options.ca_file;
  stage.prepare = prepare_options(options.draw, options.delta, options.layers);
  stage.reel.loop = options.loop.value_or(!options.offscreen);
  stage.reel.speed = options.speed;
  stage.reel.start_us = start_us(options);
  stage.reel.single_frame = single_frame(options);
  stage.live.prepare_threads = std::clamp(std::thread::hardware_concurrency(), 1u, 4u);
  return stage;
}

std::uint64_t start_us(const PlayOptions& options) {
  return static_cast<std::uint64_t>(std::llround(options.at.value_or(0.0) * 1'000'000.0));
}

Camera camera_at(const PlayOptions& options, std::uint64_t time_us, const Box& bounds, char up,
                 glm::ivec2 size) {
  Camera camera;
  camera.up = options.up.value_or(up);
  camera.frame_bounds(bounds, static_cast<double>(size.x) / size.y);
  if (options.view) {
    camera.yaw = camera.pitch = 0.0;
    camera.orbit(options.view->yaw, options.view->pitch);
  }
  return options.camera_path ? options.camera_path->at(time_us, camera) : camera;
}

Camera first_camera(const PlayOptions& options, const Box& bounds, char up, glm::ivec2 size) {
  return camera_at(options, start_us(options), bounds, up, size);
}

std::optional<FloorGrid> floor_under(const Stage& stage, const Camera& camera) {
  if (stage.bounds().empty()) return std::nullopt;
  return FloorGrid{stage.bounds(), camera.up};
}

Result<std::unique_ptr<Presenter>> Presenter::create(const PlayOptions& options) {
  std::unique_ptr<Presenter> presenter(new Presenter(options));
  auto painter = Painter::create(options.supersample);
  if (!painter) return tl::unexpected(painter.error());
  presenter->painter_ = *std::move(painter);
  presenter->report_.gl_renderer = describe_opengl();
  presenter->report_.size = options.size;
  return presenter;
}

void Presenter::begin(const Stage& stage) {
  PlayReport report;
  report.gl_renderer = report_.gl_renderer;
  report.size = report_.size;
  report.mode = options_.draw.mode;
  report.instancing = options_.draw.instancing;
  report.splatting = options_.draw.splatting;
  report.delta = options_.delta;
  for (std::size_t i = 0; i < stage.size(); ++i) {
    SourceReport& source = report.sources.emplace_back();
    source.where = stage.where(i);
    source.place = stage.place(i);
    const ReelPlayback* reel = stage.reel(i);
    if (reel != nullptr && reel->manifest().codec == "octree")
      report.finest_level =
          std::max(report.finest_level, static_cast<int>(reel->manifest().depth_max));
  }
  report_ = std::move(report);
  shown_ = false;
  started_.reset();
  draft_ = {};
}

Result<void> Presenter::show(const Stage& stage, const std::vector<Stage::Change>& changes,
                             const Camera& camera, glm::ivec2 size, const DrawOptions& draw,
                             const Haste& haste) {
  start_clock();
  shown_ = true;
  const auto stats = paint(stage, camera, size, draw, haste);
  if (!stats) return tl::unexpected(stats.error());
  drawn_ = *stats;
  for (const Stage::Change& change : changes) {
    const SceneFrame& frame = *stage.scene()[change.source].frame;
    const ReelPlayback* reel = stage.reel(change.source);
    NotFetched rest;
    if (reel != nullptr) rest = not_fetched(reel->manifest(), frame, reel->choice(frame.level));
    if (change.refined) {
      report_.add_refined(frame, rest, *stats);
      continue;
    }
    report_.add(frame, rest, *stats);
    SourceReport& source = report_.sources[change.source];
    ++source.frames_shown;
    // By two machines' clocks, which may disagree.
    if (reel == nullptr)
      source.delay.add((static_cast<double>(unix_time_us()) - static_cast<double>(frame.time_us)) /
                       1000.0);
  }
  return {};
}

Result<void> Presenter::show_again(const Stage& stage, const Camera& camera, glm::ivec2 size,
                                   const DrawOptions& draw, const Haste& haste) {
  const auto drawn = paint(stage, camera, size, draw, haste);
  if (!drawn) return tl::unexpected(drawn.error());
  drawn_ = *drawn;
  return {};
}

Result<DrawStats> Presenter::paint(const Stage& stage, const Camera& camera, glm::ivec2 size,
                                   const DrawOptions& draw, const Haste& haste) {
  report_.size = size;
  report_.mode = draw.mode;
  report_.instancing = draw.instancing;
  report_.splatting = draw.splatting;
  const std::uint64_t elements = element_count(stage.scene());
  DrawOptions options = draw;
  options.reduction = draft_.reduction(haste, elements);
  auto drawn = painter_->draw(stage.scene(), camera, size, options);
  if (drawn) draft_.drew(elements, drawn->cut_ms + drawn->render_ms);
  return drawn;
}

double Presenter::seconds() const {
  if (!started_) return 0.0;
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - *started_).count();
}

void Presenter::start_clock() {
  if (!started_) started_ = std::chrono::steady_clock::now();
}

const PlayReport& Presenter::report(const Stage& stage, std::uint64_t lost, bool every_frame) {
  report_.seconds = seconds();
  report_.frames_dropped = lost;
  report_.errors = 0;
  for (std::size_t i = 0; i < stage.size(); ++i) {
    SourceReport& source = report_.sources[i];
    source.frames_dropped = stage.playback(i).dropped();
    source.errors = stage.playback(i).errors();
    if (const LivePlayback* live = stage.live(i)) source.live = live->counts();
    if (const ReelPlayback* reel = stage.reel(i)) {
      source.reel = reel->statistics();
      source.chosen = reel->chosen();
    }
    report_.errors += source.errors;
    if (!every_frame) report_.frames_dropped += source.frames_dropped;
  }
  return report_;
}

Result<void> Presenter::write_report() const {
  if (options_.json.empty()) return {};
  const std::string text = report_.to_json();
  if (options_.json == "-") {
    const bool written =
        std::fwrite(text.data(), 1, text.size(), stdout) == text.size() && std::fflush(stdout) == 0;
    if (!written) return fail("standard output cannot be written");
    return {};
  }
  std::ofstream out(options_.json, std::ios::binary);
  out << text;
  out.close();
  if (!out) return fail(options_.json + ": cannot be written");
  return {};
}

}  // namespace pointreel
