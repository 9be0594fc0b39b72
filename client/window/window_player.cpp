#include "client/window/window_player.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <fmt/format.h>

#include "client/options/settings.h"
#include "client/playback/opening.h"
#include "client/playback/stage.h"
#include "client/record/numbered_path.h"
#include "client/render/gl_context.h"
#include "client/session/presenter.h"
#include "client/ui/controls.h"
#include "client/ui/interface.h"
#include "client/ui/timeline_view.h"
#include "client/ui/window_input.h"
#include "client/window/camera_recorder.h"
#include "client/window/error_window.h"
#include "client/window/thumbnail_painter.h"
#include "client/window/window_errors.h"

namespace pointreel {
namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;

/// Of the interface while it changes by itself; faster than this is seen by nobody.
constexpr milliseconds kInterfacePeriod{33};
/// How often it is drawn after something happened: ImGui needs a picture to find what is under the
/// cursor, one to press it, and one to release it.
constexpr int kPicturesAfterInput = 3;
/// After which a camera that was moved by hand stands still.
constexpr milliseconds kStandsStill{150};
/// After which playback that shows no other frame is taken to stand still.
constexpr milliseconds kClockStands{1000};
/// While the time is dragged the interface is drawn with the picture that is asked for; this long.
constexpr milliseconds kPictureAwaited{80};
/// Faster nobody reads.
constexpr milliseconds kStatisticsPeriod{200};

double ms_since(steady_clock::time_point start, steady_clock::time_point now) {
  return std::chrono::duration<double, std::milli>(now - start).count();
}

/// What people call it: the last part of its path or address.
std::string short_name(const std::string& where) {
  std::string text = where;
  while (text.size() > 1 && text.back() == '/') text.pop_back();
  const std::size_t slash = text.rfind('/');
  return slash == std::string::npos || slash + 1 == text.size() ? text : text.substr(slash + 1);
}

std::string short_names(const std::vector<Stage::Placed>& sources) {
  std::string names;
  for (const Stage::Placed& source : sources)
    names += (names.empty() ? "" : ", ") + short_name(source.where);
  return names;
}

class WindowPlayer {
 public:
  WindowPlayer(const PlayOptions& options, const std::stop_token& stop, WindowContext& window)
      : options_(options),
        stop_(stop),
        window_(window),
        controls_({options.draw, options.delta, options.floor, options.drafts}),
        input_(window.handle()),
        interface_(window.handle(),
                   static_cast<float>(options.ui_scale.value_or(window.content_scale()))) {
    controls_.show_drawing = options.drawing_panel;
    controls_.show_statistics = options.statistics_panel;
    input_.set_covered([this](glm::dvec2 cursor) { return interface_.covers(cursor); });
    input_.set_track([this](glm::dvec2 cursor) -> std::optional<WindowInput::Track> {
      const auto area = interface_.track_at(cursor);
      if (!area) return std::nullopt;
      return WindowInput::Track{area->left, area->right};
    });
    // Panels hear of each press and of all of a drag, however long a picture takes.
    input_.set_while_down([this](glm::dvec2 cursor, int button) {
      view_.held = Gui::Held{cursor, button};
      build_interface(steady_clock::now(), redraw_due_);
      view_.held.reset();
    });
  }

  bool run() {
    open(options_.sources);
    show_first_window();
    auto presenter = Presenter::create(options_);
    if (!presenter) {
      say_error(presenter.error().message);
      opening_.reset();
    } else {
      presenter_ = *std::move(presenter);
    }
    if (auto played = play(); !played) {
      say_error(played.error().message);
    } else if (presenter_) {
      if (auto written = finish(); !written) say_error(written.error().message);
    }
    controls_.begin(nullptr, {});
    retire(std::move(stage_));
    return errors_.failure().empty();
  }

 private:
  // Opening.

  void open(std::vector<Stage::Placed> sources) {
    opened_ = std::move(sources);
    const PlayOptions options = options_;
    const glm::ivec2 size = size_;
    opening_.emplace(
        opened_, stage_options(options_),
        [options, size](const Box& bounds, char up) {
          return first_camera(options, bounds, up, size);
        },
        [this, sources = opened_](std::size_t source, std::uint32_t frame, const Error& error) {
          errors_.broken(source, sources.size() > 1 ? sources[source].where + ": " : "", frame,
                         error);
        });
    opening_since_ = steady_clock::now();
    tell_title(short_names(opened_));
  }

  void tell_title(const std::string& names) {
    glfwSetWindowTitle(window_.handle(), ("Pointreel: " + names).c_str());
  }

  /// Of what plays, or of what could not be opened if nothing does.
  void tell_title() {
    if (!stage_) return;
    std::string names;
    for (std::size_t i = 0; i < stage_->size(); ++i)
      names += (i > 0 ? ", " : "") + stage_->playback(i).name();
    tell_title(names);
  }

  void give_up_opening(steady_clock::time_point now) {
    opening_.reset();
    tell_title();
    if (stage_)
      interface_.say("no longer loading " + short_names(opened_), now);
    else
      say_error(short_names(opened_) + ": loading was given up");
  }

  void look_whether_open(bool& changed) {
    if (!opening_ || !presenter_) return;
    auto opened = opening_->poll();
    if (!opened) return;
    opening_.reset();
    changed = true;
    if (!*opened) {
      say_error(opened->error().message);
      tell_title();
      return;
    }
    errors_.forget_failure();
    scrub_asked_.reset();
    hovered_us_.reset();
    controls_.begin(nullptr, {});
    retire(std::move(stage_));
    stage_ = *std::move(*opened);
    recent_.clear();
    drawn_mode_ = controls_.settings().draw.mode;
    presenter_->begin(*stage_);
    bounded_ = stage_->bounded();
    controls_.begin(stage_.get(), [this] {
      return camera_at(options_, camera_time_us(), stage_->bounds(), stage_->up(), size_);
    });
    tell_title();
  }

  void say_error(const std::string& message) { errors_.failed(message, steady_clock::now()); }

  // The loop.

  void show_first_window() {
    glfwPollEvents();
    glfwGetFramebufferSize(window_.handle(), &size_.x, &size_.y);
    build_interface(steady_clock::now());
    window_.clear(controls_.settings().draw.background);
    interface_.draw();
    window_.swap();
    report_.window_ms = ms_since(options_.started, steady_clock::now());
  }

  Result<void> play() {
    auto before = steady_clock::now(), last_look = before;
    const auto began = before;
    while (!stop_.stop_requested() && !quit_ && !glfwWindowShouldClose(window_.handle())) {
      wait_for_events();
      const auto now = steady_clock::now();
      const double seconds = std::min(0.1, ms_since(before, now) / 1000.0);
      before = now;
      const Input input = input_.take();
      bool redraw = std::exchange(redraw_due_, false);
      look_whether_open(redraw);
      if (input.any || redraw) pictures_due_ = kPicturesAfterInput;
      if (auto acted = act(input, now, seconds, redraw); !acted) return acted;
      if (options_.duration && over(now, began)) break;
      if (now - last_look > milliseconds(100)) {
        last_look = now;
        if (stage_ && errors_.look(*stage_, now)) pictures_due_ = std::max(pictures_due_, 1);
      }

      glm::ivec2 size{0};
      glfwGetFramebufferSize(window_.handle(), &size.x, &size.y);
      if (size.x <= 0 || size.y <= 0) {  // minimised
        pictures_due_ = 0;
        continue;
      }
      if (std::exchange(size_, size) != size) {
        redraw = true;
        pictures_due_ = kPicturesAfterInput;
        controls_.look_home_unless_moved();
      }
      Stage::Update update;
      if (stage_) update = stage_->update(now);
      if (update.ended) break;
      const bool shown = !update.changes.empty();
      if ((shown || redraw || !picture_awaited(now)) && interface_due(now))
        build_interface(now, redraw);
      if (stage_) {
        redraw = redraw || (presenter_->painter().reduced() && haste(now).of == Haste::Of::nobody);
        if (auto drawn = draw(update, now, redraw); !drawn) return drawn;
        // What was waited for is there.
        if (shown && view_.waiting != waiting()) build_interface(now, redraw);
      }
      if (shown || redraw || input.exposed || interface_.changed()) present();
    }
    if (options_.screenshot.empty() || !presenter_ || !presenter_->shown()) return {};
    return presenter_->painter().write(options_.screenshot);
  }

  /// Of real time from the first picture on, or from an error that there is none for.
  bool over(steady_clock::time_point now, steady_clock::time_point began) const {
    if (presenter_ && presenter_->shown()) return presenter_->seconds() >= *options_.duration;
    return !errors_.failure().empty() && ms_since(began, now) >= 1000.0 * *options_.duration;
  }

  bool picture_awaited(steady_clock::time_point now) const {
    return scrub_asked_ && now - *scrub_asked_ < kPictureAwaited;
  }

  void wait_for_events() const {
    if ((pictures_due_ > 0 && !picture_awaited(steady_clock::now())) || flown_)
      glfwPollEvents();
    else
      glfwWaitEventsTimeout(stage_ && (stage_->playing() || controls_.scrubbing()) ? 0.002 : 0.01);
  }

  /// Of the next picture.
  Haste haste(steady_clock::time_point now) const {
    const Drafts drafts = controls_.settings().drafts;
    if (drafts == Drafts::never) return {};
    if (!presenter_->shown() || controls_.scrubbing() || flown_ || now - moved_ < kStandsStill)
      return {Haste::Of::hand};
    if (drafts == Drafts::playing && stage_->playing() && now - shown_ < kClockStands)
      return {Haste::Of::clock, 1000.0 * stage_->frame_seconds()};
    return {};
  }

  Result<void> draw(const Stage::Update& update, steady_clock::time_point now, bool redraw) {
    const bool shown = !update.changes.empty();
    // Live streams say late where they are, and a path moves on with each frame.
    if (std::exchange(bounded_, stage_->bounded()) != stage_->bounded() ||
        (shown && options_.camera_path))
      controls_.look_home_unless_moved();
    stage_->look(controls_.camera(), size_);
    if (!shown && !redraw) return {};
    if (shown) shown_ = now;
    // Frames that were made for another mode are drawn as before until new ones are there.
    if (shown) drawn_mode_ = controls_.settings().draw.mode;
    const auto done = shown ? presenter_->show(*stage_, update.changes, controls_.camera(), size_,
                                               draw_options(), haste(now))
                            : presenter_->show_again(*stage_, controls_.camera(), size_,
                                                     draw_options(), haste(now));
    if (!done) return done;
    recent_.redrawn(presenter_->drawn());
    for (const Stage::Change& change : update.changes)
      if (!change.refined)
        recent_.add(*stage_->scene()[change.source].frame, presenter_->drawn(),
                    steady_clock::now());
    return {};
  }

  DrawOptions draw_options() const {
    DrawOptions draw = controls_.settings().draw;
    draw.mode = drawn_mode_;
    if (controls_.settings().floor) draw.floor = floor_under(*stage_, controls_.camera());
    return draw;
  }

  void present() {
    if (stage_)
      presenter_->painter().present();
    else
      window_.clear(controls_.settings().draw.background);
    window_.finish();  // what is not the interface's
    const auto start = steady_clock::now();
    interface_.draw();
    window_.finish();
    if (!interface_.empty())
      report_.interface.add(ms_since(start, steady_clock::now()) + build_ms_);
    build_ms_ = 0.0;
    window_.swap();
    note_what_is_shown(steady_clock::now());
  }

  void note_what_is_shown(steady_clock::time_point now) {
    if (!presenter_ || !presenter_->shown()) return;
    if (report_.first_picture_ms == 0.0) report_.first_picture_ms = ms_since(options_.started, now);
    if (!scrub_asked_) return;
    const ReelPlayback* reel = controls_.reel();
    const SceneFrame* frame = reel ? shown_frame() : nullptr;
    if (!frame || frame->index != scrub_frame_) return;
    report_.scrub_to_picture.add(ms_since(*scrub_asked_, now));
    scrub_asked_.reset();
  }

  /// Where a path of the camera is: at the time of the frame that is shown.
  std::uint64_t camera_time_us() const {
    const ReelPlayback* reel = controls_.reel();
    if (!reel) return static_cast<std::uint64_t>(presenter_->seconds() * 1e6);
    const SceneFrame* frame = shown_frame();
    return frame ? reel->timeline().times_us[frame->index] : start_us(options_);
  }

  /// Which source is the reel whose time the controls tell; there is one.
  std::size_t timed_source() const {
    std::size_t i = 0;
    while (stage_->reel(i) != controls_.reel()) ++i;
    return i;
  }
  /// Of that reel; null before the first one.
  const SceneFrame* shown_frame() const { return stage_->scene()[timed_source()].frame.get(); }

  // The interface.

  bool interface_due(steady_clock::time_point now) {
    if (pictures_due_ > 0) {
      --pictures_due_;
      return true;
    }
    return now - built_ >= kInterfacePeriod && interface_.changing(view_);
  }

  void build_interface(steady_clock::time_point now) {
    bool redraw = false;
    build_interface(now, redraw);
  }

  void build_interface(steady_clock::time_point now, bool& redraw) {
    const auto start = steady_clock::now();
    built_ = now;
    view_.now = now;
    int width = 1, height = 1;
    glfwGetWindowSize(window_.handle(), &width, &height);
    view_.size = {width, height};
    view_.error = errors_.shown();
    view_.hint = errors_.failure().empty() || stage_
                     ? ""
                     : "Drop a package, a folder or PLY files here, or press q to quit";
    view_.waiting = waiting();
    view_.waiting_seconds = ms_since(opening_since_, now) / 1000.0;
    view_.timeline.reset();
    if (stage_) view_.timeline = timeline_view(controls_, now);
    view_.thumbnail = thumbnail();
    tell_statistics(now);
    if (auto said = controls_.take_said()) interface_.say(*said, now);
    const DrawSettings settings = controls_.settings();
    const TimelineUse use = interface_.build(view_, controls_);
    hovered_us_ = use.hovered_us;
    if (use.action) pressed_.push_back(*use.action);
    redraw = redraw || settings != controls_.settings();
    build_ms_ += ms_since(start, steady_clock::now());
  }

  void tell_statistics(steady_clock::time_point now) {
    if (!stage_ || !controls_.show_statistics) {
      view_.statistics.clear();
    } else if (view_.statistics.empty() || now - told_ >= kStatisticsPeriod) {
      told_ = now;
      view_.statistics = statistics_lines(*stage_, recent_, now);
      view_.recent = recent_;
    }
  }

  std::string waiting() const {
    if (opening_) {
      const auto trouble = opening_->trouble();
      return "Loading " + short_names(opened_) +
             (trouble ? "\n" + *trouble + "; ESC gives up" : "");
    }
    if (stage_ && !presenter_->shown()) return "Waiting for the first picture";
    return {};
  }

  /// Of the time that the cursor is at, once its frame is there; no other picture while it is not,
  /// and none while the window itself shows that time.
  std::optional<Thumbnail> thumbnail() {
    if (!hovered_us_ || !controls_.reel() || controls_.scrubbing()) return std::nullopt;
    const std::size_t source = timed_source();
    auto base =
        stage_->reel(source)->thumbnail(controls_.reel()->timeline().frame_at(*hovered_us_));
    if (!base) return std::nullopt;
    return thumbnails_.draw({std::move(base), stage_->place(source)}, stage_->bounds(),
                            controls_.camera(), controls_.settings().draw.background);
  }

  /// The time is dragged, or was let go.
  void scrub(const Input& input, steady_clock::time_point now, bool& redraw) {
    const ReelPlayback* reel = controls_.reel();
    if (reel && input.scrub) {
      if (!controls_.scrubbing()) scrub_asked_.reset();
      const auto time_us = static_cast<std::uint64_t>(
          *input.scrub * static_cast<double>(reel->timeline().duration_us));
      controls_.scrub_to(time_us, now);
      scrub_frame_ = reel->timeline().frame_at(time_us);
      const SceneFrame* shown = shown_frame();
      if (shown && shown->index == scrub_frame_)
        scrub_asked_.reset();
      else if (!scrub_asked_)
        scrub_asked_ = now;
    }
    if (!input.scrubbing && controls_.scrubbing()) {
      controls_.scrub_end(now);
      redraw = true;  // as it is to be
    }
  }

  // What the user does.

  Result<void> act(const Input& input, steady_clock::time_point now, double seconds, bool& redraw) {
    if (input.moved) interface_.wake(now);
    if (!input.dropped.empty()) open(sources_of(input.dropped));
    std::vector<Action> actions = std::exchange(pressed_, {});
    actions.insert(actions.end(), input.actions.begin(), input.actions.end());
    for (const Action action : actions) {
      if (interface_.scroll_help(action)) continue;
      const DrawSettings before = controls_.settings();
      const Camera camera = controls_.camera();
      if (!controls_.act(action, now)) {
        if (auto done = act_on_window(action, now); !done) return done;
      }
      redraw = redraw || before != controls_.settings() || camera != controls_.camera();
    }
    if (input.unknown)
      interface_.say(fmt::format("{} does nothing; ? shows the keys", *input.unknown), now);
    if (input.centered && stage_) {
      if (const auto point = presenter_->painter().point_at(in_pixels(*input.centered))) {
        controls_.center_on(*point);
        redraw = true;
      }
    }
    scrub(input, now, redraw);
    input_.set_flying(controls_.flying());
    flown_ = input.fly != glm::dvec3(0.0);
    Input in_picture = input;
    in_picture.cursor = in_pixels(input.cursor);
    if (controls_.move(in_picture, size_, seconds)) {
      moved_ = now;
      redraw = true;
    }
    return {};
  }

  glm::dvec2 in_pixels(glm::dvec2 cursor) const {
    int width = 1, height = 1;
    glfwGetWindowSize(window_.handle(), &width, &height);
    return cursor * glm::dvec2(size_) / glm::dvec2(std::max(1, width), std::max(1, height));
  }

  Result<void> act_on_window(Action action, steady_clock::time_point now) {
    if (action == Action::quit) {
      quit_ = true;
    } else if (action == Action::leave && opening_) {
      give_up_opening(now);
    } else if (action == Action::toggle_fullscreen ||
               (action == Action::leave && input_.fullscreen())) {
      input_.toggle_fullscreen();
    } else if (action == Action::add_camera_key) {
      if (const ReelPlayback* reel = controls_.reel())
        interface_.say(camera_recorder_.add(controls_.camera(), reel->position_us(now)), now);
    } else if (action == Action::screenshot && presenter_ && presenter_->shown()) {
      const std::string path = NumberedPath::parse("pointreel-%04d.png")->first_free();
      const auto written = presenter_->painter().write(path);
      const std::string said = written ? "wrote " + path : written.error().message;
      fmt::print(stderr, "pointreel: {}\n", said);
      interface_.say(said, now);
    }
    return {};
  }

  /// What the user has changed by hand or key, for the next time.
  Result<void> keep_settings() const {
    if (options_.settings_file.empty()) return {};
    PlayOptions ended = options_;
    const DrawSettings& settings = controls_.settings();
    ended.draw = settings.draw;
    ended.delta = settings.delta;
    ended.floor = settings.floor;
    ended.drafts = settings.drafts;
    ended.drawing_panel = controls_.show_drawing;
    ended.statistics_panel = controls_.show_statistics;
    if (controls_.reel()) ended.loop = controls_.reel()->loop();
    if (!input_.fullscreen()) glfwGetWindowSize(window_.handle(), &ended.size.x, &ended.size.y);
    return write_settings(options_.settings_file, options_, ended);
  }

  Result<void> finish() {
    if (stage_) {
      presenter_->report(*stage_, 0, false);
      report_.camera = controls_.camera();
      report_.playing = stage_->playing();
      if (const ReelPlayback* reel = controls_.reel()) {
        report_.playing = reel->playing();
        report_.loop = reel->loop();
        report_.speed = reel->speed();
        report_.loop_range = reel->loop_range();
        const std::uint64_t at = reel->position_us(steady_clock::now());
        report_.position_s = static_cast<double>(at) * 1e-6;
        report_.frame = reel->timeline().frame_at(at);
      }
    }
    if (auto kept = keep_settings(); !kept) return kept;
    report_.help = controls_.show_help;
    report_.drawing = controls_.show_drawing;
    report_.statistics = controls_.show_statistics;
    report_.floor = controls_.settings().floor;
    report_.flying = controls_.flying();
    report_.error = view_.error;
    presenter_->set_window(report_, controls_.settings().draw.mode);
    return presenter_->write_report();
  }

  const PlayOptions& options_;
  const std::stop_token stop_;
  WindowContext& window_;
  glm::ivec2 size_ = options_.size;  ///< of the picture, in pixels
  WindowErrors errors_;
  std::unique_ptr<Presenter> presenter_;  ///< null until the first window has been shown
  std::vector<Stage::Placed> opened_;
  RecentFrames recent_;
  std::unique_ptr<Stage> stage_;  ///< null until the first one is open
  std::optional<Opening> opening_;
  steady_clock::time_point opening_since_{};
  std::size_t bounded_ = 0;                   ///< sources that the camera was framed on
  DrawMode drawn_mode_ = options_.draw.mode;  ///< what the frames shown were made for
  Controls controls_;
  WindowInput input_;
  Interface interface_;  ///< after the input, whose callbacks it chains itself to
  Interface::View view_;
  ThumbnailPainter thumbnails_{interface_.scale()};
  std::optional<std::uint64_t> hovered_us_;  ///< the time that the cursor is at
  steady_clock::time_point moved_{};         ///< the camera, by hand
  steady_clock::time_point shown_{};         ///< another frame
  std::vector<Action> pressed_;              ///< of buttons, for the next round
  int pictures_due_ = 0;
  bool redraw_due_ = false;
  steady_clock::time_point built_{}, told_{};
  double build_ms_ = 0.0;  ///< since the window last changed
  bool flown_ = false, quit_ = false;
  CameraRecorder camera_recorder_;
  std::optional<steady_clock::time_point> scrub_asked_;
  std::uint32_t scrub_frame_ = 0;
  WindowReport report_;
};

}  // namespace

bool play_in_window(const PlayOptions& options, const std::stop_token& stop) {
  auto window = WindowContext::create("Pointreel: " + short_names(options.sources), options.size.x,
                                      options.size.y);
  if (!window) {
    const std::string message =
        window.error().message + "; --offscreen WxH draws without a display";
    fmt::print(stderr, "pointreel: {}\n", message);
    show_error_window("Pointreel", message, options.duration, stop);
    return false;
  }
  return WindowPlayer(options, stop, *window).run();
}

}  // namespace pointreel
