#include "client/session/presenter.h"

#include <algorithm>
#include <cstdio>
#include <utility>

#include "common/base/try.h"
#include "common/base/unix_time.h"
#include "common/file_system/write_file.h"
#include "common/process/print.h"

namespace pointreel {

Presenter::Presenter(const PlayOptions& options, std::unique_ptr<Renderer> renderer)
    : options_(options), painter_(std::move(renderer), options.supersample) {
  report_.renderer = painter_.describe_renderer();
  report_.size = options.picture_size();
}

void Presenter::set_renderer(std::unique_ptr<Renderer> renderer) {
  painter_ = Painter(std::move(renderer), options_.supersample);
  report_.renderer = painter_.describe_renderer();
  draft_ = {};
  shot_.reset();
}

void Presenter::begin(const Stage& stage) {
  PlayReport report;
  report.renderer = report_.renderer;
  report.size = report_.size;
  report.mode = options_.settings.draw.mode;
  report.instancing = options_.settings.draw.instancing;
  report.splatting = options_.settings.draw.splatting;
  report.delta = options_.settings.delta;
  for (std::size_t i = 0; i < stage.size(); ++i) {
    SourceReport& source = report.sources.emplace_back();
    source.where = stage.where(i);
    source.place = stage.place(i);
    const ReelPlayback* reel = stage.reel(i);
    if (reel != nullptr && reel->manifest().codec != "draco")
      report.finest_level =
          std::max(report.finest_level, static_cast<int>(reel->manifest().depth_max));
  }
  report_ = std::move(report);
  shown_ = false;
  started_.reset();
  draft_ = {};
  shot_.reset();
}

Result<void> Presenter::draw(const Stage& stage, const std::vector<Stage::Change>& changes,
                             const Shot& shot) {
  if (!changes.empty()) {
    start_clock();
    shown_ = true;
  }
  shot_ = shot;
  report_.size = shot.size;
  report_.mode = shot.draw.mode;
  report_.instancing = shot.draw.instancing;
  report_.splatting = shot.draw.splatting;
  const std::uint64_t elements = element_count(stage.scene());
  DrawOptions options = shot.draw;
  const DraftCoarsening coarsening = draft_.coarsening(shot.haste, elements);
  options.refine = options.refine && shot.haste.of == Haste::Of::nobody;
  hasty_ = coarsening != DraftCoarsening{} || options.refine != shot.draw.refine;
  drawn_ = TRY(painter_.draw(stage.scene(), shot.camera, shot.size, options, coarsening));
  draft_.drew(elements, drawn_.cut_ms + drawn_.render_ms);
  for (const Stage::Change& change : changes) add_to_report(stage, change);
  return {};
}

bool Presenter::shows(const Shot& shot) const {
  return shot_ && shot_->camera == shot.camera && shot_->size == shot.size &&
         shot_->draw == shot.draw;
}

void Presenter::add_to_report(const Stage& stage, const Stage::Change& change) {
  const SceneFrame& frame = *stage.scene()[change.source].frame;
  const ReelPlayback* reel = stage.reel(change.source);
  NotFetched rest;
  if (reel != nullptr) rest = not_fetched(reel->manifest(), frame, reel->choice(frame.level));
  if (change.refined) {
    report_.add_refined(frame, rest, drawn_);
    return;
  }
  report_.add(frame, rest, drawn_);
  SourceReport& source = report_.sources[change.source];
  ++source.frames_shown;
  // A live frame was captured by the time of another machine, which may disagree with this one.
  if (reel == nullptr)
    source.delay.add((static_cast<double>(unix_time_us()) - static_cast<double>(frame.time_us)) /
                     1000.0);
}

double Presenter::seconds() const {
  if (!started_) return 0.0;
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - *started_).count();
}

void Presenter::start_clock() {
  if (!started_) started_ = std::chrono::steady_clock::now();
}

void Presenter::count(const Stage& stage, std::optional<std::uint64_t> lost) {
  report_.seconds = seconds();
  report_.frames_dropped = lost.value_or(0);
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
    if (!lost) report_.frames_dropped += source.frames_dropped;
  }
}

Result<void> Presenter::write_report() const {
  if (options_.json.empty()) return {};
  const std::string text = report_.to_json();
  if (options_.json == "-") {
    if (!print_lines(text)) return fail(ErrorCode::io, "standard output cannot be written");
    return {};
  }
  return write_file(options_.json, text);
}

}  // namespace pointreel
