#include "client/window_player.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <memory>
#include <string>
#include <utility>

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <fmt/format.h>

#include "client/capture.h"
#include "client/console.h"
#include "client/playback/stage.h"
#include "client/presenter.h"
#include "client/render/gl_context.h"
#include "client/ui/window_input.h"

namespace pointreel {
namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;

class WindowPlayer {
 public:
  WindowPlayer(const PlayOptions& options, const std::stop_token& stop)
      : options_(options), stop_(stop), draw_(options.draw) {}

  Result<void> run() {
    auto stage = Stage::open(
        options_.sources, stage_options(options_),
        [this](const Box& bounds, char up) { return first_camera(options_, bounds, up, size_); },
        [this](std::size_t source, std::uint32_t frame, const Error& error) {
          const auto& sources = options_.sources;
          errors_.print(source, sources.size() > 1 ? sources[source].where + ": " : "", frame,
                        error);
        });
    if (!stage) return tl::unexpected(stage.error());
    stage_ = *std::move(stage);
    auto context = WindowContext::create(title(), options_.size.x, options_.size.y);
    if (!context)
      return fail(context.error().message + "; --offscreen WxH draws without a display");
    auto presenter = Presenter::create(options_);
    if (!presenter) return tl::unexpected(presenter.error());
    presenter_ = *std::move(presenter);
    presenter_->begin(*stage_);
    reset_view();
    Result<void> ended;
    {
      WindowInput input(context->handle());
      ended = play(*context, input);
    }
    presenter_->report(*stage_, 0, false);
    stage_.reset();
    if (ended) ended = presenter_->write_report();
    presenter_.reset();  // before its context
    return ended;
  }

 private:
  void reset_view() { camera_ = first_camera(options_, stage_->bounds(), stage_->up(), size_); }

  Result<void> play(WindowContext& window, WindowInput& input) {
    bool redraw = true;
    auto last_look = steady_clock::now();
    while (!stop_.stop_requested() && !quit_ && !glfwWindowShouldClose(window.handle())) {
      wait_for_events(redraw);
      redraw = false;
      const auto now = steady_clock::now();
      if (auto acted = act(input, now, redraw); !acted) return acted;
      if (options_.duration && presenter_->shown() && presenter_->seconds() >= *options_.duration)
        break;
      const Stage::Update update = stage_->update(now);
      if (update.ended) break;

      glm::ivec2 size{0};
      glfwGetFramebufferSize(window.handle(), &size.x, &size.y);
      if (size.x <= 0 || size.y <= 0) continue;  // minimised
      redraw = redraw || size != size_;
      size_ = size;
      frame_what_came();
      stage_->look(camera_, size_);

      if (!update.changes.empty()) {
        draw_.mode = wanted_mode_;
        if (auto drawn = presenter_->show(*stage_, update.changes, camera_, size_, draw_); !drawn)
          return drawn;
        redraw = true;
      } else if (redraw) {
        if (auto drawn = presenter_->show_again(*stage_, camera_, size_, draw_); !drawn)
          return drawn;
      }
      if (redraw) {
        presenter_->painter().present();
        window.swap();
      }
      if (now - last_look > milliseconds(100)) {
        last_look = now;
        trouble_.look(*stage_);
        update_title(window.handle());
      }
    }
    if (options_.screenshot.empty() || !presenter_->shown()) return {};
    return presenter_->painter().write(options_.screenshot);
  }

  void wait_for_events(bool redraw) const {
    if (redraw)
      glfwPollEvents();
    else
      glfwWaitEventsTimeout(stage_->playing() ? 0.002 : 0.01);
  }

  /// Live streams say late where they are: looks at everything anew, unless the user has chosen
  /// where to look from.
  void frame_what_came() {
    if (stage_->bounded() == bounded_) return;
    bounded_ = stage_->bounded();
    if (!moved_) reset_view();
  }

  Result<void> act(WindowInput& input, Clock::TimePoint now, bool& redraw) {
    const Input events = input.take();
    const double height = std::max(1, size_.y);
    if (events.orbit != glm::dvec2(0.0)) {
      // Once across the height of the picture is half a turn.
      camera_.orbit(-events.orbit.x / height * M_PI, events.orbit.y / height * M_PI);
      moved_ = redraw = true;
    }
    if (events.pan != glm::dvec2(0.0)) {
      camera_.pan(-events.pan.x / height, events.pan.y / height);
      moved_ = redraw = true;
    }
    if (events.wheel != 0.0) {
      camera_.zoom(std::pow(0.9, events.wheel));
      moved_ = redraw = true;
    }
    scrub(events, now);
    for (const Action action : events.actions) {
      switch (action) {
        case Action::toggle_play:
          stage_->for_each_reel([&](ReelPlayback& reel) { reel.toggle_play(now); });
          break;
        case Action::seek_forward:
        case Action::seek_back:
          stage_->for_each_reel([&](ReelPlayback& reel) {
            reel.seek_by(action == Action::seek_forward ? 5'000'000 : -5'000'000, now);
          });
          break;
        case Action::step_forward:
        case Action::step_back:
          stage_->for_each_reel(
              [&](ReelPlayback& reel) { reel.step(action == Action::step_forward ? 1 : -1, now); });
          break;
        case Action::slower:
          stage_->for_each_reel(
              [&](ReelPlayback& reel) { reel.set_speed(reel.speed() / 1.1, now); });
          break;
        case Action::faster:
          stage_->for_each_reel(
              [&](ReelPlayback& reel) { reel.set_speed(reel.speed() * 1.1, now); });
          break;
        case Action::normal_speed:
          stage_->for_each_reel([&](ReelPlayback& reel) { reel.set_speed(1.0, now); });
          break;
        case Action::turn_around:
          stage_->for_each_reel([&](ReelPlayback& reel) { reel.set_speed(-reel.speed(), now); });
          break;
        case Action::toggle_loop:
          stage_->for_each_reel([&](ReelPlayback& reel) { reel.toggle_loop(now); });
          break;
        case Action::next_mode:
          wanted_mode_ = static_cast<DrawMode>((static_cast<int>(wanted_mode_) + 1) % 3);
          stage_->set_mode(wanted_mode_);
          break;
        case Action::next_instancing:
          draw_.instancing = next(draw_.instancing);
          tell_how_is_drawn();
          redraw = true;
          break;
        case Action::next_splatting:
          draw_.splatting = next(draw_.splatting);
          tell_how_is_drawn();
          redraw = true;
          break;
        case Action::toggle_fullscreen:
          input.toggle_fullscreen();
          break;
        case Action::screenshot: {
          const std::string path = NumberedPath::parse("pointreel-%04d.png")->first_free();
          const auto written = presenter_->painter().write(path);
          fmt::print(stderr, "pointreel: {}\n",
                     written ? "wrote " + path : written.error().message);
          break;
        }
        case Action::toggle_statistics:
          statistics_ = !statistics_;
          title_stale_ = true;
          break;
        case Action::reset_view:
          moved_ = false;
          reset_view();
          redraw = true;
          break;
        case Action::help:
          fmt::print(stderr, "{}", bindings_help());
          break;
        case Action::quit:
          quit_ = true;
          break;
      }
    }
    return {};
  }

  void scrub(const Input& events, Clock::TimePoint now) {
    stage_->for_each_reel([&](ReelPlayback& reel) {
      if (events.scrub) {
        if (!reel.scrubbing()) reel.scrub_begin(now);
        reel.scrub_to(static_cast<std::uint64_t>(*events.scrub *
                                                 static_cast<double>(reel.timeline().duration_us)),
                      now);
      }
      if (!events.scrubbing && reel.scrubbing()) reel.scrub_end(now);
    });
  }

  void tell_how_is_drawn() {
    fmt::print(stderr, "pointreel: instancing {}, splatting {}\n", name(draw_.instancing),
               name(draw_.splatting));
  }

  std::string title() const {
    std::string names;
    for (std::size_t i = 0; i < stage_->size(); ++i)
      names += (i > 0 ? ", " : "") + stage_->playback(i).name();
    return "Pointreel: " + names;
  }

  void update_title(GLFWwindow* window) {
    if (!statistics_ && !title_stale_) return;
    if (!title_stale_ && steady_clock::now() - last_title_ < milliseconds(500)) return;
    title_stale_ = false;
    last_title_ = steady_clock::now();
    const PlayReport& report = presenter_->report(*stage_, 0, false);
    glfwSetWindowTitle(window,
                       (statistics_ ? title() + ": " + report.to_title() : title()).c_str());
  }

  const PlayOptions& options_;
  const std::stop_token stop_;
  DrawOptions draw_;
  DrawMode wanted_mode_ = options_.draw.mode;  ///< what frames are being made for
  ErrorLines errors_;
  TroubleLines trouble_;
  std::unique_ptr<Stage> stage_;
  std::unique_ptr<Presenter> presenter_;
  glm::ivec2 size_ = options_.size;
  Camera camera_;
  bool moved_ = false;       ///< the user has chosen where to look from
  std::size_t bounded_ = 0;  ///< sources that the camera was framed on
  steady_clock::time_point last_title_{};
  bool statistics_ = false, title_stale_ = false, quit_ = false;
};

}  // namespace

Result<void> play_in_window(const PlayOptions& options, const std::stop_token& stop) {
  return WindowPlayer(options, stop).run();
}

}  // namespace pointreel
