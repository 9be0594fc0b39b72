#include "client/window/window_picture.h"

#include <utility>

#include "client/render/make_renderer.h"
#include "client/session/stage_setup.h"
#include "common/base/try.h"

namespace pointreel {

Result<std::unique_ptr<WindowPicture>> WindowPicture::create(const PlayOptions& options,
                                                             Controls& controls) {
  std::unique_ptr<WindowPicture> picture(new WindowPicture(options, controls));
  picture->renderer_ = controls.settings().renderer;
  picture->presenter_ =
      std::make_unique<Presenter>(options, TRY(make_window_renderer(picture->renderer_)));
  return picture;
}

void WindowPicture::begin(const Stage& stage) {
  presenter_->begin(stage);
  view_version_ = stage.view_version();
  mode_ = controls_.settings().draw.mode;
}

Camera WindowPicture::home(const Stage& stage, glm::ivec2 size) const {
  std::uint64_t time_us = start_us(options_);
  if (!controls_.reel())
    time_us = static_cast<std::uint64_t>(presenter_->seconds() * 1e6);
  else if (const SceneFrame* frame = controls_.shown_frame())
    time_us = controls_.reel()->timeline().times_us[frame->index];
  const Up up = controls_.settings().up.value_or(stage.up());
  return camera_at(options_, time_us, stage.view_bounds(), up, size);
}

Result<bool> WindowPicture::draw(Stage& stage, const Stage::Update& update, glm::ivec2 size,
                                 TimePoint now, RecentFrames& recent) {
  const bool shown = !update.changes.empty();
  // What there is to see is known only later, and a camera path moves with each frame.
  if (std::exchange(view_version_, stage.view_version()) != stage.view_version() ||
      (shown && options_.camera_path))
    controls_.look_home_unless_moved();
  stage.look(controls_.camera(), size);
  if (shown) {
    motion_.show_frame(now);
    // After a change of the mode, frames are drawn in the old one until there are others.
    mode_ = controls_.settings().draw.mode;
  }
  const bool by_hand = !presenter_->shown() || controls_.scrubbing();
  const Shot shot{controls_.camera(), size, draw_options(stage),
                  motion_.haste(controls_.settings().drafts, stage, by_hand, now)};
  bool other_renderer = false;
  if (const RendererChoice wanted = controls_.settings().renderer; wanted != renderer_) {
    presenter_->set_renderer(TRY(make_window_renderer(wanted)));
    renderer_ = wanted;
    other_renderer = true;
  }
  const bool finer = presenter_->hasty() && shot.haste.of == Haste::Of::nobody;
  if (!shown && !finer && !other_renderer && presenter_->shows(shot)) return false;
  TRY(presenter_->draw(stage, update.changes, shot));
  recent.redrawn(presenter_->drawn());
  for (const Stage::Change& change : update.changes)
    if (!change.refined)
      recent.add(*stage.scene()[change.source].frame, presenter_->drawn(),
                 std::chrono::steady_clock::now());
  return true;
}

std::optional<WindowPicture::TimePoint> WindowPicture::next_draw(TimePoint now) const {
  if (motion_.flying()) return now;
  if (presenter_->hasty()) return motion_.next_rest(now);
  return std::nullopt;
}

DrawOptions WindowPicture::draw_options(const Stage& stage) const {
  DrawOptions draw = controls_.settings().draw;
  draw.refine = controls_.settings().refine == Refine::automatic;
  draw.smooth_outlines = controls_.settings().smooth_outlines;
  draw.mode = mode_;
  if (controls_.settings().floor) draw.floor = floor_under(stage, controls_.camera());
  return draw;
}

}  // namespace pointreel
