#include "client/ui/interface.h"

#include <algorithm>
#include <chrono>
#include <utility>

#include "client/ui/drawing_panel.h"
#include "client/ui/overlay.h"
#include "client/ui/panel.h"
#include "client/ui/panel_layout.h"
#include "client/ui/statistics_panel.h"
#include "common/process/print.h"

namespace pointreel {
namespace {

using Seconds = std::chrono::duration<double>;

constexpr double kBarSeconds = 1.8, kFadeSeconds = 0.25, kSaidSeconds = 1.5;
constexpr int kLinesPerPage = 10;  ///< of the help

}  // namespace

void Interface::say(const std::string& text, Now now) {
  said_ = visible(text);
  said_at_ = now;
}

float Interface::opacity(Now now) const {
  if (busy_) return 1.0f;
  const double idle = Seconds(now - awake_).count() - kBarSeconds;
  return static_cast<float>(1.0 - std::clamp(idle / kFadeSeconds, 0.0, 1.0));
}

bool Interface::covers(glm::dvec2 cursor) const {
  return cursor.y >= static_cast<double>(bar_top_) || gui_.covers(cursor);
}

std::optional<TrackArea> Interface::track_at(glm::dvec2 cursor) const {
  const auto in = [](double value, float from, float to) {
    return value >= static_cast<double>(from) && value <= static_cast<double>(to);
  };
  if (!track_ || !in(cursor.x, track_->left, track_->right) ||
      !in(cursor.y, track_->top, track_->bottom) || gui_.covers(cursor, kTimelineWindow))
    return std::nullopt;
  return track_;
}

bool Interface::changing(const View& view) const {
  return !view.waiting.empty() || !said_.empty() || (view.timeline && opacity(view.now) > 0.0f) ||
         (!empty_ && view.error.empty());
}

bool Interface::scroll_help(Action action) {
  if (!help_scrolls_) return false;
  switch (action) {
    case Action::seek_forward_far:  // UP
      help_lines_down_ -= 1;
      return true;
    case Action::seek_back_far:  // DOWN
      help_lines_down_ += 1;
      return true;
    case Action::seek_forward_tenth:  // PGUP
      help_lines_down_ -= kLinesPerPage;
      return true;
    case Action::seek_back_tenth:  // PGDWN
      help_lines_down_ += kLinesPerPage;
      return true;
    default:
      return false;
  }
}

TimelineUse Interface::build(const View& view, Controls& controls) {
  const TimelineUse first = build_once(view, controls);
  if (!gui_.settling()) return first;
  TimelineUse use = build_once(view, controls);
  if (first.action) use.action = first.action;
  return use;
}

TimelineUse Interface::build_once(const View& view, Controls& controls) {
  TimelineUse use;
  gui_.begin(view.held);
  empty_ = true;
  const float scale = gui_.scale();
  if (!view.waiting.empty()) {
    draw_waiting(view.waiting, view.size, scale, view.waiting_seconds);
    empty_ = false;
  }
  if (Seconds(view.now - said_at_).count() > kSaidSeconds) said_.clear();
  const std::string said = said_.empty() ? controls.unusual_keys() : said_;
  float error = 0.0f;
  if (!view.error.empty())
    error = draw_error(view.error, view.hint, view.size, scale);
  else if (!said.empty())
    draw_said(said, scale);
  empty_ = empty_ && view.error.empty() && said.empty();

  const float bar = opacity(view.now);
  track_.reset();
  if (view.timeline && !view.timeline->live) track_ = track_area(view.size, scale);
  gui_.show_cursor(!view.timeline || bar > 0.0f);  // as in mpv
  bar_top_ = view.timeline ? view.size.y - kTimelineHeight * scale : 1e9f;
  if (view.timeline && bar > 0.0f) {
    use =
        draw_timeline(*view.timeline, view.thumbnail, controls.scrubbing(), view.size, scale, bar);
    empty_ = false;
  }
  if (view.legend) {
    draw_legend(*view.legend, {0.0f, std::min(bar_top_, view.size.y)}, scale);
    empty_ = false;
  }
  busy_ = use.hovered_us || controls.scrubbing();
  build_panels(view, error, controls);
  if (controls.show_help) {
    const HelpUse help = draw_help(view.size, scale, std::exchange(help_lines_down_, 0));
    controls.show_help = help.open;
    help_scrolls_ = help.open && help.scrolls;
    empty_ = false;
  } else {
    help_scrolls_ = false;
  }
  gui_.end();
  return use;
}

void Interface::build_panels(const View& view, float error, Controls& controls) {
  Settings settings = controls.settings();
  const bool drawing = settings.drawing_panel;
  const bool statistics = settings.statistics_panel && !view.statistics.empty();
  const float scale = gui_.scale();
  const PanelLayout layout = place_panels(
      view.size, error, scale, drawing ? natural_size(kDrawingPanel) : glm::vec2(0.0f),
      statistics
          ? glm::max(natural_size(kStatisticsPanel), glm::vec2(kStatisticsWidth * scale, 0.0f))
          : glm::vec2(0.0f));
  // The user may drag panels elsewhere. They are placed again when their room has changed, and once
  // more because ImGui knows the size of a new panel only then.
  const PanelState state{view.size, scale, error, drawing, statistics, layout.stacked};
  if (state != std::exchange(panels_, state)) placings_due_ = 2;
  const bool place = placings_due_ > 0;
  if (place) --placings_due_;
  if (statistics) {
    settings.statistics_panel =
        draw_statistics(view.statistics, view.recent, layout.statistics, place, scale);
  }
  if (drawing) drawing_panel(settings, view.fields, layout.drawing, place, scale);
  empty_ = empty_ && !drawing && !statistics;
  if (settings != controls.settings()) controls.set_settings(settings);
}

void Interface::draw() { gui_.draw(); }

}  // namespace pointreel
