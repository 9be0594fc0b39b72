#include "client/player.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <fstream>
#include <limits>
#include <memory>
#include <thread>
#include <utility>

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <fmt/format.h>

#include "client/capture.h"
#include "client/console.h"
#include "client/painter.h"
#include "client/playback/stage.h"
#include "client/render/gl_context.h"
#include "client/report.h"
#include "client/ui/window_input.h"

namespace pointreel {
namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;

/// Set by SIGINT and SIGTERM. A handler can reach nothing but a global.
std::atomic<bool> g_stop{false};
static_assert(std::atomic<bool>::is_always_lock_free);

void stop_on_signals() {
  struct sigaction action{};
  action.sa_handler = [](int) { g_stop = true; };
  action.sa_flags = static_cast<int>(SA_RESETHAND);  // a second one ends the process at once
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
}

std::uint64_t microseconds(double seconds) {
  return static_cast<std::uint64_t>(std::llround(seconds * 1e6));
}

double seconds_since(steady_clock::time_point start) {
  return std::chrono::duration<double>(steady_clock::now() - start).count();
}

std::uint64_t unix_time_us() {
  return static_cast<std::uint64_t>(std::chrono::duration_cast<std::chrono::microseconds>(
                                        std::chrono::system_clock::now().time_since_epoch())
                                        .count());
}

/// What a window and a playback without one have in common.
class Player {
 public:
  static Result<std::unique_ptr<Player>> create(const PlayOptions& options) {
    auto player = std::unique_ptr<Player>(new Player(options));
    Player* self = player.get();
    auto stage = Stage::open(
        options.sources, player->stage_options(),
        [self](const Box& bounds, char up) {
          self->reset_view(bounds, up, self->options_.size);
          return self->camera_;
        },
        [self](std::size_t source, std::uint32_t frame, const Error& error) {
          const auto& sources = self->options_.sources;
          self->errors_.print(source, sources.size() > 1 ? sources[source].where + ": " : "", frame,
                              error);
        });
    if (!stage) return tl::unexpected(stage.error());
    player->stage_ = *std::move(stage);
    player->begin_report();
    return player;
  }

  Result<void> run() {
    auto ended = options_.offscreen ? play_offscreen() : play_in_window();
    stage_.reset();
    if (!ended) return ended;
    return write_json();
  }

 private:
  explicit Player(const PlayOptions& options) : options_(options), draw_(options.draw) {}

  Stage::Options stage_options() const {
    Stage::Options stage;
    stage.size = options_.size;
    stage.source.fps = options_.fps;
    stage.source.up = options_.up.value_or('y');
    stage.source.token = options_.token;
    stage.source.ca_file = options_.ca_file;
    stage.reel.mode = stage.live.mode = draw_.mode;
    stage.reel.delta = stage.live.delta = options_.delta;
    stage.reel.layers = stage.live.layers = options_.layers;
    stage.reel.pixel_size = stage.live.pixel_size = draw_.pixel_size;
    stage.reel.loop = options_.loop.value_or(!options_.offscreen);
    stage.reel.speed = options_.speed;
    stage.reel.start_us = microseconds(options_.at.value_or(0.0));
    stage.reel.single_frame = single_frame();
    stage.live.prepare_threads = std::clamp(std::thread::hardware_concurrency(), 1u, 4u);
    return stage;
  }

  void begin_report() {
    report_.mode = draw_.mode;
    report_.instancing = draw_.instancing;
    report_.splatting = draw_.splatting;
    report_.delta = options_.delta;
    report_.size = options_.size;
    for (std::size_t i = 0; i < stage_->size(); ++i) {
      SourceReport& source = report_.sources.emplace_back();
      source.where = options_.sources[i].where;
      source.place = options_.sources[i].place;
      const ReelPlayback* reel = stage_->reel(i);
      if (reel != nullptr && reel->manifest().codec == "octree")
        report_.finest_level =
            std::max(report_.finest_level, static_cast<int>(reel->manifest().depth_max));
    }
  }

  /// Without a window, and without anything that has a time of its own.
  bool every_frame() const { return stage_->size() == 1 && stage_->reel(0) != nullptr; }
  bool single_frame() const {
    return options_.offscreen && options_.at && !options_.duration && options_.sources.size() == 1;
  }

  void reset_view(const Box& bounds, char up, glm::ivec2 size) {
    camera_.up = options_.up.value_or(up);
    camera_.frame_bounds(bounds, static_cast<double>(size.x) / size.y);
    if (options_.view) {
      camera_.yaw = camera_.pitch = 0.0;
      camera_.orbit(options_.view->yaw, options_.view->pitch);
    }
  }

  /// Draws the scene with what has changed in it.
  Result<void> show(const std::vector<Stage::Change>& changes, glm::ivec2 size) {
    if (!started_) started_ = steady_clock::now();
    shown_ = true;
    const auto stats = painter_->draw(stage_->scene(), camera_, size, draw_);
    if (!stats) return tl::unexpected(stats.error());
    for (const Stage::Change& change : changes) {
      const SceneFrame& frame = *stage_->scene()[change.source].frame;
      const ReelPlayback* reel = stage_->reel(change.source);
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
        source.delay.add(
            (static_cast<double>(unix_time_us()) - static_cast<double>(frame.time_us)) / 1000.0);
    }
    return {};
  }

  void finish() {
    if (started_) report_.seconds = seconds_since(*started_);
    count();
  }

  void count() {
    report_.frames_dropped = lost_;
    report_.errors = 0;
    for (std::size_t i = 0; i < stage_->size(); ++i) {
      SourceReport& source = report_.sources[i];
      source.frames_dropped = stage_->playback(i).dropped();
      source.errors = stage_->playback(i).errors();
      if (const LivePlayback* live = stage_->live(i)) source.live = live->counts();
      if (const ReelPlayback* reel = stage_->reel(i)) {
        source.reel = reel->statistics();
        source.chosen = reel->chosen();
      }
      report_.errors += source.errors;
      // Where every frame is waited for, nothing is ever late.
      if (!options_.offscreen || !every_frame()) report_.frames_dropped += source.frames_dropped;
    }
  }

  Result<void> begin_drawing() {
    auto painter = Painter::create(options_.supersample);
    if (!painter) return tl::unexpected(painter.error());
    painter_ = *std::move(painter);
    report_.gl_renderer = describe_opengl();
    return {};
  }

  /// Of the reel alone, every frame once, in order; else in real time.
  Result<void> play_offscreen() {
    auto context = OffscreenContext::create();
    if (!context) return tl::unexpected(context.error());
    if (auto begun = begin_drawing(); !begun) return begun;
    started_ = steady_clock::now();
    auto ended =
        every_frame() ? play_every_frame(*stage_->reel(0)) : play_in_real_time(nullptr, nullptr);
    finish();
    painter_.reset();
    return ended;
  }

  Result<void> play_in_window() {
    auto context = WindowContext::create(title(), options_.size.x, options_.size.y);
    if (!context)
      return fail(context.error().message + "; --offscreen WxH draws without a display");
    if (auto begun = begin_drawing(); !begun) return begun;
    Result<void> ended;
    {
      WindowInput input(context->handle());
      ended = play_in_real_time(&*context, &input);
    }
    finish();
    painter_.reset();
    return ended;
  }

  Result<void> play_every_frame(ReelPlayback& reel) {
    const Timeline& timeline = reel.timeline();
    const std::uint32_t count = timeline.frame_count();
    const std::uint32_t first = timeline.frame_at(microseconds(options_.at.value_or(0.0)));
    const bool loop = options_.loop.value_or(false);
    // A frame's time since the start, through all passes.
    const std::uint64_t start_us = timeline.times_us[first];
    const std::uint64_t end_us = options_.duration ? microseconds(*options_.duration)
                                                   : std::numeric_limits<std::uint64_t>::max();
    for (std::uint64_t ordinal = first; !g_stop; ++ordinal) {
      if (ordinal >= count && !loop) break;
      const auto frame = static_cast<std::uint32_t>(ordinal % count);
      const std::uint64_t time_us =
          ordinal / count * timeline.duration_us + timeline.times_us[frame] - start_us;
      if (time_us >= end_us) break;
      FrameBuffer::State state = FrameBuffer::State::waiting;
      while (state == FrameBuffer::State::waiting && !g_stop) {
        state = reel.await(frame, milliseconds(50));
        trouble_.look(*stage_);
      }
      if (state == FrameBuffer::State::ready) {
        if (auto drawn = show(stage_->take(0, reel.best()), options_.size); !drawn) return drawn;
      } else if (state == FrameBuffer::State::failed) {
        ++lost_;
      } else {
        break;
      }
      if (auto written = record(); !written) return written;
      if (single_frame()) break;
    }
    if (!shown_ && !g_stop) return fail(options_.sources[0].where + ": no frame could be shown");
    return last_screenshot();
  }

  Result<void> record() {
    if (options_.record.empty() || !shown_) return {};
    return painter_->write(NumberedPath::parse(options_.record)->at(recorded_++));
  }

  Result<void> last_screenshot() {
    if (options_.screenshot.empty() || !shown_) return {};
    return painter_->write(options_.screenshot);
  }

  /// `window` and `input` are null where there is none.
  Result<void> play_in_real_time(WindowContext* window, WindowInput* input) {
    bool redraw = true;
    auto last_look = steady_clock::now();
    glm::ivec2 size = options_.size;
    while (!g_stop && !quit_ && !(window && glfwWindowShouldClose(window->handle()))) {
      wait_for_events(window, redraw);
      redraw = false;
      const auto now = steady_clock::now();
      if (input) {
        if (auto acted = act(*input, now, redraw); !acted) return acted;
      }
      if (options_.duration && shown_ && seconds_since(*started_) >= *options_.duration) break;
      const Stage::Update update = stage_->update(now);
      if (update.ended) break;

      glm::ivec2 new_size = options_.size;
      if (window) glfwGetFramebufferSize(window->handle(), &new_size.x, &new_size.y);
      if (new_size.x <= 0 || new_size.y <= 0) continue;  // minimised
      redraw = redraw || new_size != size;
      report_.size = size = new_size;
      frame_what_came(size);
      stage_->look(camera_, size);

      if (!update.changes.empty()) {
        draw_.mode = wanted_mode_;
        if (auto drawn = show(update.changes, size); !drawn) return drawn;
        if (auto written = record(); !written) return written;
        redraw = true;
      } else if (redraw) {
        const auto drawn = painter_->draw(stage_->scene(), camera_, size, draw_);
        if (!drawn) return tl::unexpected(drawn.error());
      }
      if (redraw && window) {
        painter_->present();
        window->swap();
      }
      if (seconds_since(last_look) > 0.1) {
        last_look = now;
        trouble_.look(*stage_);
        if (window) update_title(window->handle());
      }
    }
    return last_screenshot();
  }

  void wait_for_events(WindowContext* window, bool redraw) const {
    if (!window) {
      std::this_thread::sleep_for(milliseconds(1));
    } else if (redraw) {
      glfwPollEvents();
    } else {
      glfwWaitEventsTimeout(stage_->playing() ? 0.002 : 0.01);
    }
  }

  /// Live streams say late where they are: looks at everything anew, unless the user has chosen
  /// where to look from.
  void frame_what_came(glm::ivec2 size) {
    if (stage_->bounded() == bounded_) return;
    bounded_ = stage_->bounded();
    if (!moved_) reset_view(stage_->bounds(), stage_->up(), size);
  }

  Result<void> act(WindowInput& input, Clock::TimePoint now, bool& redraw) {
    const Input events = input.take();
    const double height = std::max(1, report_.size.y);
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
          report_.mode = wanted_mode_;
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
          const auto written = painter_->write(path);
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
          reset_view(stage_->bounds(), stage_->up(), report_.size);
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
    report_.instancing = draw_.instancing;
    report_.splatting = draw_.splatting;
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
    if (!title_stale_ && seconds_since(last_title_) < 0.5) return;
    title_stale_ = false;
    last_title_ = steady_clock::now();
    count();
    glfwSetWindowTitle(window,
                       (statistics_ ? title() + ": " + report_.to_title() : title()).c_str());
  }

  Result<void> write_json() const {
    if (options_.json.empty()) return {};
    const std::string text = report_.to_json();
    if (options_.json == "-") {
      const bool written = std::fwrite(text.data(), 1, text.size(), stdout) == text.size() &&
                           std::fflush(stdout) == 0;
      if (!written) return fail("standard output cannot be written");
      return {};
    }
    std::ofstream out(options_.json, std::ios::binary);
    out << text;
    out.close();
    if (!out) return fail(options_.json + ": cannot be written");
    return {};
  }

  const PlayOptions options_;
  DrawOptions draw_;
  DrawMode wanted_mode_ = options_.draw.mode;  ///< what frames are being made for
  ErrorLines errors_;
  TroubleLines trouble_;
  std::unique_ptr<Stage> stage_;
  std::unique_ptr<Painter> painter_;
  Camera camera_;
  bool moved_ = false;       ///< the user has chosen where to look from
  std::size_t bounded_ = 0;  ///< sources that the camera was framed on
  PlayReport report_;
  std::uint64_t lost_ = 0;  ///< frames of every one that were skipped for being broken
  std::uint64_t recorded_ = 0;
  bool shown_ = false;
  std::optional<steady_clock::time_point> started_;
  steady_clock::time_point last_title_{};
  bool statistics_ = false, title_stale_ = false, quit_ = false;
};

}  // namespace

Result<void> play(const PlayOptions& options) {
  auto player = Player::create(options);
  if (!player) return tl::unexpected(player.error());
  stop_on_signals();
  return (*player)->run();
}

}  // namespace pointreel
