#include "client/window/window_interface.h"

#include <algorithm>
#include <utility>

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

#include "client/ui/interface_scale.h"
#include "client/ui/timeline_view.h"
#include "common/process/print.h"

namespace pointreel {
namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;

/// While it changes by itself. Nobody sees it change faster.
constexpr milliseconds kPeriod{33};
/// After input ImGui needs one picture to find what is under the cursor, one to press it, and one
/// to release it.
constexpr int kBuildsAfterInput = 3;
/// Nobody reads numbers that change faster.
constexpr milliseconds kStatisticsPeriod{200};
constexpr milliseconds kScalePeriod{1000};

double ms_since(steady_clock::time_point start) {
  return std::chrono::duration<double, std::milli>(steady_clock::now() - start).count();
}

}  // namespace

WindowInterface::WindowInterface(WindowContext& window, const WindowSession& session,
                                 const WindowErrors& errors, Controls& controls)
    : window_(window),
      session_(session),
      errors_(errors),
      controls_(controls),
      interface_(window.handle(), interface_scale(window.handle(), controls.settings().ui_scale)) {}

void WindowInterface::forget() {
  hovered_us_.reset();
  recent_.clear();
}

void WindowInterface::refresh() { builds_due_ = kBuildsAfterInput; }

void WindowInterface::refresh_once() { builds_due_ = std::max(builds_due_, 1); }

std::optional<WindowInterface::TimePoint> WindowInterface::next_build() const {
  if (builds_due_ > 0) return built_;
  if (interface_.changing(view_)) return built_ + kPeriod;
  return std::nullopt;
}

void WindowInterface::build_for_button(glm::dvec2 cursor, int button, bool down) {
  build(steady_clock::now(), Gui::Held{cursor, button, down});
}

void WindowInterface::update_waiting(TimePoint now) {
  if (view_.waiting != session_.waiting()) build(now);
}

void WindowInterface::build(TimePoint now, const std::optional<Gui::Held>& held) {
  const auto start = steady_clock::now();
  if (!held) builds_due_ = std::max(0, builds_due_ - 1);
  built_ = now;
  view_.now = now;
  view_.held = held;
  update_scale(now);
  int width = 1, height = 1;
  glfwGetWindowSize(window_.handle(), &width, &height);
  view_.size = {width, height};
  view_.error = visible(errors_.shown());
  view_.hint = errors_.failure().empty() || session_.stage()
                   ? ""
                   : "Drop a package, a folder or PLY files here, or press q to quit";
  view_.waiting = session_.waiting();
  view_.waiting_seconds = session_.waiting_seconds(now);
  view_.timeline.reset();
  if (session_.stage()) view_.timeline = timeline_view(controls_, now);
  view_.legend.reset();
  view_.fields.clear();
  if (const Stage* stage = session_.stage()) {
    view_.legend = legend_of(stage->scene());
    view_.fields = stage->scalar_names();
  }
  view_.thumbnail = thumbnail();
  update_statistics(now);
  if (auto said = controls_.take_said()) interface_.say(*said, now);
  const TimelineUse use = interface_.build(view_, controls_);
  hovered_us_ = use.hovered_us;
  if (use.action) pressed_.push_back(*use.action);
  build_ms_ += ms_since(start);
}

void WindowInterface::update_scale(TimePoint now) {
  // To ask for the screen takes a while, and the window seldom moves to another one.
  const double wanted = controls_.settings().ui_scale;
  if (wanted == wanted_scale_ && now - scale_updated_ < kScalePeriod) return;
  wanted_scale_ = wanted;
  scale_updated_ = now;
  interface_.set_scale(interface_scale(window_.handle(), wanted));
}

void WindowInterface::update_statistics(TimePoint now) {
  if (!session_.stage() || !controls_.settings().statistics_panel) {
    view_.statistics.clear();
  } else if (view_.statistics.empty() || now - statistics_updated_ >= kStatisticsPeriod) {
    statistics_updated_ = now;
    view_.statistics = statistics_lines(*session_.stage(), recent_, now);
    view_.recent = recent_;
  }
}

/// The frame at the time under the cursor, once it is there. No picture of another frame stands in
/// for it, and there is none while the window itself shows that time.
std::optional<Thumbnail> WindowInterface::thumbnail() {
  if (!hovered_us_ || !controls_.reel() || controls_.scrubbing()) return std::nullopt;
  const Stage& stage = *session_.stage();
  ReelPlayback& reel = *stage.reel(controls_.source());
  auto base = reel.thumbnail(reel.timeline().frame_at(*hovered_us_));
  if (!base) return std::nullopt;
  return thumbnails_.draw({std::move(base), stage.place(controls_.source())}, stage.view_bounds(),
                          controls_.camera(), controls_.settings().draw.background,
                          controls_.settings().renderer, interface_.scale());
}

void WindowInterface::draw(bool timed) {
  if (timed) window_.finish();  // what was drawn before does not count
  const auto start = steady_clock::now();
  interface_.draw();
  if (timed) {
    window_.finish();
    if (!interface_.empty()) times_.add(ms_since(start) + build_ms_);
  }
  build_ms_ = 0.0;
}

}  // namespace pointreel
