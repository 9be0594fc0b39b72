#include "client/window/window_player.h"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <functional>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <utility>
#include <vector>

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <fmt/format.h>

#include "client/playback/stage.h"
#include "client/record/numbered_path.h"
#include "client/render/opengl/gl_context.h"
#include "client/session/stage_setup.h"
#include "client/source/open_source.h"
#include "client/ui/controls.h"
#include "client/ui/interface_scale.h"
#include "client/ui/window_input.h"
#include "client/window/camera_recorder.h"
#include "client/window/error_window.h"
#include "client/window/keep_settings.h"
#include "client/window/scrubbing.h"
#include "client/window/wakeups.h"
#include "client/window/window_errors.h"
#include "client/window/window_interface.h"
#include "client/window/window_picture.h"
#include "client/window/window_report.h"
#include "client/window/window_session.h"
#include "common/base/try.h"
#include "common/process/print.h"

namespace pointreel {
namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;

/// How often the loop looks at things that do not wake it, such as errors that have been shown for
/// long enough.
constexpr milliseconds kLookPeriod{100};

double seconds_between(steady_clock::time_point start, steady_clock::time_point end) {
  return std::chrono::duration<double>(end - start).count();
}

class WindowPlayer {
 public:
  WindowPlayer(const PlayOptions& options, const std::stop_token& stop, WindowContext& window)
      : options_(options),
        stop_(stop),
        window_(window),
        session_(options, errors_, [wakeups = wakeups_] { wakeups->wake(); }),
        controls_(options.settings),
        input_(window.handle()),
        interface_(window, session_, errors_, controls_) {
    input_.set_covered([this](glm::dvec2 cursor) { return interface_.parts().covers(cursor); });
    input_.set_track([this](glm::dvec2 cursor) -> std::optional<WindowInput::Track> {
      const auto area = interface_.parts().track_at(cursor);
      if (!area) return std::nullopt;
      return WindowInput::Track{area->left, area->right};
    });
    input_.set_on_button([this](glm::dvec2 cursor, int button, bool down) {
      interface_.build_for_button(cursor, button, down);
    });
  }

  bool run() {
    open(options_.sources);
    show_first_window();
    if (auto picture = WindowPicture::create(options_, controls_)) {
      picture_ = *std::move(picture);
    } else {
      fail_with(picture.error().message);
      session_.give_up_opening();
    }
    Result<void> played = loop();
    if (played && picture_) played = finish();
    if (!played) fail_with(played.error().message);
    controls_.begin(nullptr, {});
    session_.play(nullptr);
    return errors_.failure().empty();
  }

 private:
  // The session.

  void open(std::vector<Stage::Placed> sources) {
    session_.open(std::move(sources), controls_.settings(), size_);
    set_title(session_.opened_names());
  }

  void set_title(const std::string& names) {
    glfwSetWindowTitle(window_.handle(), ("Pointreel: " + names).c_str());
  }

  /// Back to what plays, if anything does, after something else could not be opened.
  void restore_title() {
    if (session_.stage()) set_title(session_.playing_names());
  }

  /// Whether the window has shown a frame of what plays.
  bool shown() const { return picture_ && picture_->presenter().shown(); }

  void fail_with(const std::string& message) { errors_.failed(message, steady_clock::now()); }

  void give_up_opening(steady_clock::time_point now) {
    session_.give_up_opening();
    restore_title();
    if (session_.stage())
      interface_.parts().say("no longer loading " + session_.opened_names(), now);
    else
      fail_with(session_.opened_names() + ": loading was given up");
  }

  void play_what_was_opened() {
    auto opened = session_.take_opened();
    if (!opened) return;
    interface_.refresh();
    if (*opened) {
      play(**std::move(opened));
    } else {
      fail_with(opened->error().message);
    }
    restore_title();
  }

  void play(std::unique_ptr<Stage> stage) {
    errors_.forget_failure();
    scrubbing_.forget();
    interface_.forget();
    controls_.begin(nullptr, {});
    session_.play(std::move(stage));
    picture_->begin(*session_.stage());
    if (const auto found = check_scalar_field(controls_.settings(), *session_.stage()); !found)
      interface_.parts().say(found.error().message, steady_clock::now());
    controls_.begin(session_.stage(), [this] { return picture_->home(*session_.stage(), size_); });
  }

  // The loop.

  /// Before OpenGL's programs are compiled, which takes a while.
  void show_first_window() {
    glfwPollEvents();
    glfwGetFramebufferSize(window_.handle(), &size_.x, &size_.y);
    interface_.build(steady_clock::now());
    present();
    report_.window_ms = 1000.0 * seconds_between(options_.started, steady_clock::now());
  }

  Result<void> loop() {
    auto before = steady_clock::now(), last_look = before;
    while (!stop_.stop_requested() && !quit_ && !glfwWindowShouldClose(window_.handle())) {
      wakeups_->wait(next_round(steady_clock::now()));
      const auto now = steady_clock::now();
      // Keys that were not held before the wait have not moved anything during it.
      const double seconds = flying_ ? std::min(0.1, seconds_between(before, now)) : 0.0;
      before = now;
      const Input input = input_.take();
      if (input.any) interface_.refresh();
      if (picture_) play_what_was_opened();
      act(input, now, seconds);
      if (now >= end_of_duration(options_)) {
        if (!shown() && errors_.failure().empty()) fail_with(nothing_came(options_).message);
        break;
      }
      if (now - last_look >= kLookPeriod) {
        last_look = now;
        if (session_.stage() && errors_.look(*session_.stage(), now)) interface_.refresh_once();
      }
      update_size();
      if (minimized_) continue;
      Stage::Update update;
      if (session_.stage()) update = session_.stage()->update(now);
      session_.follow_time(controls_.settings());
      if (update.ended) {
        if (auto why = session_.stage()->refusal()) fail_with(why->message);
        break;
      }
      update_due_ = update.due;
      TRY(draw_round(update, input, now));
    }
    return options_.screenshot.empty() || !shown() ? Result<void>()
                                                   : picture_->painter().write(options_.screenshot);
  }

  /// The time of the next round of the loop, unless there are events or news before.
  steady_clock::time_point next_round(steady_clock::time_point now) const {
    auto next = now + kLookPeriod;
    const auto at_most = [&](std::optional<steady_clock::time_point> time) {
      if (time) next = std::min(next, *time);
    };
    at_most(end_of_duration(options_));
    if (minimized_) return next;
    at_most(update_due_);
    if (const auto build = interface_.next_build())
      at_most(std::max(*build, scrubbing_.awaited_until()));
    if (picture_) at_most(picture_->next_draw(now));
    return next;
  }

  void update_size() {
    glm::ivec2 size{0};
    glfwGetFramebufferSize(window_.handle(), &size.x, &size.y);
    minimized_ = size.x <= 0 || size.y <= 0;
    if (minimized_ || std::exchange(size_, size) == size) return;
    interface_.refresh();
    controls_.look_home_unless_moved();
  }

  // Drawing.

  /// Brings the interface, the picture and the window up to date.
  Result<void> draw_round(const Stage::Update& update, const Input& input,
                          steady_clock::time_point now) {
    const bool shown = !update.changes.empty();
    const auto build = interface_.next_build();
    if (build && now >= *build && (shown || now >= scrubbing_.awaited_until()))
      interface_.build(now);
    bool drawn = false;
    if (session_.stage()) {
      drawn = TRY(picture_->draw(*session_.stage(), update, size_, now, interface_.recent()));
      if (shown) interface_.update_waiting(now);
    }
    if (drawn || input.exposed || interface_.parts().changed()) present();
    return {};
  }

  void present() {
    if (session_.stage())
      picture_->painter().present();
    else
      window_.clear(controls_.settings().draw.background);
    interface_.draw(!options_.json.empty());
    window_.swap();
    if (!shown()) return;
    const auto now = steady_clock::now();
    if (report_.first_picture_ms == 0.0)
      report_.first_picture_ms = 1000.0 * seconds_between(options_.started, now);
    scrubbing_.show(controls_.shown_frame(), now);
  }

  // What the user does.

  void act(const Input& input, steady_clock::time_point now, double seconds) {
    if (input.moved) interface_.parts().wake(now);
    if (!input.dropped.empty()) open(sources_of(input.dropped));
    std::vector<Action> actions = interface_.take_pressed();
    actions.insert(actions.end(), input.actions.begin(), input.actions.end());
    for (const Action action : actions) {
      if (!interface_.parts().scroll_help(action) && !controls_.act(action, now))
        act_on_window(action, now);
    }
    if (input.unknown)
      interface_.parts().say(fmt::format("{} does nothing; ? shows the keys", *input.unknown), now);
    if (input.centered && session_.stage()) {
      if (const auto point = picture_->painter().point_at(in_pixels(*input.centered)))
        controls_.center_on(*point);
    }
    scrubbing_.drag(input, controls_, controls_.shown_frame(), now);
    input_.set_flying(controls_.flying());
    flying_ = input.fly != glm::dvec3(0.0);
    Input in_picture = input;
    in_picture.cursor = in_pixels(input.cursor);
    const bool moved = controls_.move(in_picture, size_, seconds);
    if (!picture_) return;
    picture_->motion().set_flying(flying_);
    if (moved) picture_->motion().move_camera(now);
  }

  glm::dvec2 in_pixels(glm::dvec2 cursor) const {
    int width = 1, height = 1;
    glfwGetWindowSize(window_.handle(), &width, &height);
    return cursor * glm::dvec2(size_) / glm::dvec2(std::max(1, width), std::max(1, height));
  }

  void act_on_window(Action action, steady_clock::time_point now) {
    if (action == Action::quit) {
      quit_ = true;
    } else if (action == Action::leave && session_.opening()) {
      give_up_opening(now);
    } else if (action == Action::toggle_fullscreen ||
               (action == Action::leave && input_.fullscreen())) {
      input_.toggle_fullscreen();
    } else if (action == Action::larger_interface || action == Action::smaller_interface) {
      Settings settings = controls_.settings();
      settings.ui_scale =
          next_interface_scale(interface_.parts().scale(), action == Action::larger_interface);
      controls_.set_settings(settings);
      interface_.parts().say(fmt::format("interface {:.0f} %", 100.0 * settings.ui_scale), now);
    } else if (action == Action::add_camera_key) {
      if (const ReelPlayback* reel = controls_.reel())
        interface_.parts().say(camera_recorder_.add(controls_.camera(), reel->position_us(now)),
                               now);
    } else if (action == Action::screenshot && shown()) {
      const std::string path = NumberedPath::parse("pointreel-%04d.png")->first_free();
      const auto written = picture_->painter().write(path);
      const std::string said = written ? "wrote " + path : written.error().message;
      print_error("pointreel", said);
      interface_.parts().say(said, now);
    }
  }

  Result<void> finish() {
    Presenter& presenter = picture_->presenter();
    if (session_.stage()) presenter.count(*session_.stage());
    TRY(keep_settings(options_, controls_.settings(), window_, input_));
    describe_end(controls_, steady_clock::now(), report_);
    report_.interface = interface_.times();
    report_.scrub_to_picture = scrubbing_.times();
    report_.error = interface_.error();
    report_.audio = session_.audio();
    if (report_.audio && report_.audio->first_heard)
      report_.first_sound_ms =
          1000.0 * seconds_between(options_.started, *report_.audio->first_heard);
    presenter.set_window(report_, controls_.settings().draw.mode);
    return presenter.write_report();
  }

  const PlayOptions& options_;
  const std::stop_token stop_;
  WindowContext& window_;
  // Shared with whoever may still call wake() when the player has ended.
  const std::shared_ptr<Wakeups> wakeups_ = std::make_shared<Wakeups>();
  const std::stop_callback<std::function<void()>> wake_to_stop_{
      stop_, [wakeups = wakeups_] { wakeups->wake(); }};
  glm::ivec2 size_ = options_.settings.size;  ///< of the picture, in pixels
  bool minimized_ = false;
  WindowErrors errors_;
  WindowSession session_;
  Controls controls_;
  WindowInput input_;
  WindowInterface interface_;  ///< after the input, to whose callbacks it chains itself
  std::unique_ptr<WindowPicture> picture_;  ///< null until the first window has been shown
  Scrubbing scrubbing_;
  CameraRecorder camera_recorder_;
  bool flying_ = false;                                 ///< keys that fly the camera are held
  std::optional<steady_clock::time_point> update_due_;  ///< of the stage
  bool quit_ = false;
  WindowReport report_;
};

}  // namespace

bool play_in_window(const PlayOptions& options, const std::stop_token& stop) {
  const glm::ivec2 size = options.settings.size;
  auto window = WindowContext::create("Pointreel: " + short_names(options.sources), size.x, size.y);
  if (!window) {
    // What is not there could not be played on another display, either.
    for (const Stage::Placed& source : options.sources) {
      if (const auto there = source.files.empty() ? check_is_there(source.where) : Result<void>();
          !there) {
        print_error("pointreel", there.error().message);
        return false;
      }
    }
    const std::string message =
        window.error().message + "; --offscreen WIDTHxHEIGHT draws without a display";
    print_error("pointreel", message);
    show_error_window("Pointreel", message, options.settings.ui_scale, end_of_duration(options),
                      stop);
    return false;
  }
  return WindowPlayer(options, stop, *window).run();
}

}  // namespace pointreel
