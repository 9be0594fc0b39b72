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
#include <mutex>
#include <set>
#include <thread>
#include <utility>

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <fmt/format.h>

#include "client/capture.h"
#include "client/playback/reel_playback.h"
#include "client/render/gl_context.h"
#include "client/render/supersampling.h"
#include "client/report.h"
#include "client/source/open_source.h"
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

/// One line for each broken frame, however often it is tried.
class ErrorLines {
 public:
  void print(std::uint32_t frame, const Error& error) {
    const std::lock_guard lock(mutex_);
    if (printed_.insert(frame).second)
      fmt::print(stderr, "pointreel: frame {}: {}\n", frame, error.message);
  }

 private:
  std::mutex mutex_;
  std::set<std::uint32_t> printed_;
};

std::uint64_t microseconds(double seconds) {
  return static_cast<std::uint64_t>(std::llround(seconds * 1e6));
}

double seconds_since(steady_clock::time_point start) {
  return std::chrono::duration<double>(steady_clock::now() - start).count();
}

/// What a window and a playback without one have in common.
class Player {
 public:
  static Result<std::unique_ptr<Player>> create(const PlayOptions& options) {
    SourceOptions source_options;
    source_options.fps = options.fps;
    source_options.up = options.up.value_or('y');
    auto source = open_source(options.source, source_options);
    if (!source) return tl::unexpected(source.error());
    if ((*source)->manifest().frame_count() == 0)
      return fail(options.source + ": the reel has no frames");
    return std::unique_ptr<Player>(new Player(options, std::move(*source)));
  }

  Result<void> run() {
    auto ended = options_.offscreen ? play_offscreen() : play_in_window();
    reel_.reset();
    if (!ended) return ended;
    return write_json();
  }

 private:
  Player(const PlayOptions& options, std::unique_ptr<Source> source)
      : options_(options), draw_(options.draw) {
    report_.source = options.source;
    report_.mode = options.draw.mode;
    report_.instancing = options.draw.instancing;
    report_.splatting = options.draw.splatting;
    report_.delta = options.delta;
    if (source->manifest().codec == "octree")
      report_.finest_level = static_cast<int>(source->manifest().depth_max);
    report_.size = options.size;
    reset_view(source->manifest(), options.size);

    ReelPlayback::Options reel;
    reel.mode = draw_.mode;
    reel.delta = options.delta;
    reel.layers = options.layers;
    reel.pixel_size = draw_.pixel_size;
    reel.loop = options.loop.value_or(!options.offscreen);
    reel.speed = options.speed;
    reel.start_us = microseconds(options.at.value_or(0.0));
    reel.remote = options.source.find("://") != std::string::npos;
    reel.single_frame = single_frame();
    reel_ = std::make_unique<ReelPlayback>(
        std::move(source), reel, camera_, options.size,
        [this](std::uint32_t frame, const Error& error) { errors_.print(frame, error); });
  }

  bool single_frame() const { return options_.offscreen && options_.at && !options_.duration; }

  void reset_view(const Manifest& manifest, glm::ivec2 size) {
    camera_.up = options_.up.value_or(manifest.up);
    camera_.frame_bounds(manifest.bounds, static_cast<double>(size.x) / size.y);
    if (options_.view) {
      camera_.yaw = camera_.pitch = 0.0;
      camera_.orbit(options_.view->yaw, options_.view->pitch);
    }
  }

  Result<void> screenshot(const std::string& path) {
    auto image = renderer_->read_pixels();
    if (!image) return tl::unexpected(image.error());
    if (options_.supersample > 1) {
      if (auto averaged = supersample(*image); !averaged) return averaged;
    }
    return write_png(path, *image);
  }

  /// Draws what is shown once more, larger, and then as it was.
  Result<void> supersample(Image& image) {
    const int times = options_.supersample;
    const glm::ivec2 size(image.width, image.height);
    DrawOptions larger = draw_;
    larger.point_size *= static_cast<float>(times);
    larger.pixel_size *= static_cast<float>(times);
    if (const auto drawn = renderer_->draw(shown_, camera_, times * size, larger); !drawn)
      return tl::unexpected(drawn.error());
    const auto large = renderer_->read_pixels();
    if (!large) return tl::unexpected(large.error());
    image = average_squares(*large, times);
    if (const auto drawn = renderer_->draw(shown_, camera_, size, draw_); !drawn)
      return tl::unexpected(drawn.error());
    return {};
  }

  /// Draws `frame`, a new one, or the one shown with more levels.
  Result<void> show(std::shared_ptr<const SceneFrame> frame, glm::ivec2 size, bool refined) {
    if (!started_) started_ = steady_clock::now();
    const auto stats = renderer_->draw(frame, camera_, size, draw_);
    if (!stats) return tl::unexpected(stats.error());
    const NotFetched rest = not_fetched(reel_->manifest(), *frame, reel_->choice(frame->level));
    if (refined)
      report_.add_refined(*frame, rest, *stats);
    else
      report_.add(*frame, rest, *stats);
    shown_ = std::move(frame);
    return {};
  }

  void finish() {
    if (started_) report_.seconds = seconds_since(*started_);
    count();
  }

  void count() {
    // Offscreen nothing is ever late.
    if (!options_.offscreen) report_.frames_dropped = reel_->dropped();
    report_.errors = reel_->errors();
  }

  // Without a window: every frame once, in order.

  Result<void> play_offscreen() {
    auto context = OffscreenContext::create();
    if (!context) return tl::unexpected(context.error());
    auto renderer = Renderer::create();
    if (!renderer) return tl::unexpected(renderer.error());
    renderer_.emplace(std::move(*renderer));
    report_.gl_renderer = describe_opengl();
    started_ = steady_clock::now();
    auto ended = play_every_frame();
    finish();
    renderer_.reset();
    return ended;
  }

  Result<void> play_every_frame() {
    std::optional<NumberedPath> record;
    if (!options_.record.empty()) record = *NumberedPath::parse(options_.record);
    const Timeline& timeline = reel_->timeline();
    const std::uint32_t count = timeline.frame_count();
    const std::uint32_t first = timeline.frame_at(microseconds(options_.at.value_or(0.0)));
    const bool loop = options_.loop.value_or(false);
    // A frame's time since the start, through all passes.
    const std::uint64_t start_us = timeline.times_us[first];
    const std::uint64_t end_us = options_.duration ? microseconds(*options_.duration)
                                                   : std::numeric_limits<std::uint64_t>::max();
    std::uint64_t recorded = 0;
    for (std::uint64_t ordinal = first; !g_stop; ++ordinal) {
      if (ordinal >= count && !loop) break;
      const auto frame = static_cast<std::uint32_t>(ordinal % count);
      const std::uint64_t time_us =
          ordinal / count * timeline.duration_us + timeline.times_us[frame] - start_us;
      if (time_us >= end_us) break;
      FrameBuffer::State state = FrameBuffer::State::waiting;
      while (state == FrameBuffer::State::waiting && !g_stop)
        state = reel_->await(frame, milliseconds(50));
      if (state == FrameBuffer::State::ready) {
        if (auto drawn = show(reel_->best(), options_.size, false); !drawn) return drawn;
      } else if (state == FrameBuffer::State::failed) {
        ++report_.frames_dropped;
      } else {
        break;
      }
      if (record && shown_) {
        if (auto written = screenshot(record->at(recorded++)); !written) return written;
      }
      if (single_frame()) break;
    }
    if (!shown_ && !g_stop) return fail(options_.source + ": no frame could be shown");
    if (!options_.screenshot.empty() && shown_) return screenshot(options_.screenshot);
    return {};
  }

  // In a window: in real time.

  Result<void> play_in_window() {
    auto context = WindowContext::create("Pointreel: " + reel_->manifest().name, options_.size.x,
                                         options_.size.y);
    if (!context)
      return fail(context.error().message + "; --offscreen WxH draws without a display");
    auto renderer = Renderer::create();
    if (!renderer) return tl::unexpected(renderer.error());
    renderer_.emplace(std::move(*renderer));
    report_.gl_renderer = describe_opengl();
    Result<void> ended;
    {
      WindowInput input(context->handle());
      ended = play_in_real_time(*context, input);
    }
    finish();
    renderer_.reset();
    return ended;
  }

  Result<void> play_in_real_time(WindowContext& context, WindowInput& input) {
    GLFWwindow* window = context.handle();
    bool redraw = true;
    auto last_title = steady_clock::now();
    glm::ivec2 size{0};
    while (!g_stop && !quit_ && !glfwWindowShouldClose(window)) {
      if (redraw)
        glfwPollEvents();
      else
        glfwWaitEventsTimeout(reel_->playing() ? 0.002 : 0.01);
      redraw = false;

      const auto now = steady_clock::now();
      if (auto acted = act(input, now, redraw); !acted) return acted;
      if (options_.duration && shown_ && seconds_since(*started_) >= *options_.duration) break;
      const ReelPlayback::Update update = reel_->update(now);
      if (update.ended) break;

      glm::ivec2 window_size;
      glfwGetFramebufferSize(window, &window_size.x, &window_size.y);
      if (window_size.x <= 0 || window_size.y <= 0) continue;  // minimised
      redraw = redraw || window_size != size;
      report_.size = size = window_size;
      reel_->look(camera_, size);

      if (update.frame && update.frame != shown_) {
        draw_.mode = wanted_mode_;
        if (auto drawn = show(update.frame, size, update.refined); !drawn) return drawn;
        redraw = true;
      } else if (redraw) {
        const auto drawn = renderer_->draw(shown_, camera_, size, draw_);
        if (!drawn) return tl::unexpected(drawn.error());
      }
      if (redraw) {
        renderer_->present(0);
        context.swap();
      }
      if (seconds_since(last_title) > 0.5) {
        last_title = now;
        update_title(window);
      }
    }
    if (!options_.screenshot.empty() && shown_) return screenshot(options_.screenshot);
    return {};
  }

  Result<void> act(WindowInput& input, Clock::TimePoint now, bool& redraw) {
    const Input events = input.take();
    const double height = std::max(1, report_.size.y);
    if (events.orbit != glm::dvec2(0.0)) {
      // Once across the height of the picture is half a turn.
      camera_.orbit(-events.orbit.x / height * M_PI, events.orbit.y / height * M_PI);
      redraw = true;
    }
    if (events.pan != glm::dvec2(0.0)) {
      camera_.pan(-events.pan.x / height, events.pan.y / height);
      redraw = true;
    }
    if (events.wheel != 0.0) {
      camera_.zoom(std::pow(0.9, events.wheel));
      redraw = true;
    }
    for (const Action action : events.actions) {
      switch (action) {
        case Action::toggle_play:
          reel_->toggle_play(now);
          break;
        case Action::seek_forward:
        case Action::seek_back:
          reel_->seek_by(action == Action::seek_forward ? 5'000'000 : -5'000'000, now);
          break;
        case Action::step_forward:
        case Action::step_back:
          reel_->step(action == Action::step_forward ? 1 : -1, now);
          break;
        case Action::slower:
          reel_->set_speed(reel_->speed() / 1.1, now);
          break;
        case Action::faster:
          reel_->set_speed(reel_->speed() * 1.1, now);
          break;
        case Action::toggle_loop:
          reel_->toggle_loop(now);
          break;
        case Action::next_mode:
          wanted_mode_ = static_cast<DrawMode>((static_cast<int>(wanted_mode_) + 1) % 3);
          report_.mode = wanted_mode_;
          reel_->set_mode(wanted_mode_);
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
          const auto written = screenshot(path);
          fmt::print(stderr, "pointreel: {}\n",
                     written ? "wrote " + path : written.error().message);
          break;
        }
        case Action::toggle_statistics:
          statistics_ = !statistics_;
          title_stale_ = true;
          break;
        case Action::reset_view:
          reset_view(reel_->manifest(), report_.size);
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

  void tell_how_is_drawn() {
    report_.instancing = draw_.instancing;
    report_.splatting = draw_.splatting;
    fmt::print(stderr, "pointreel: instancing {}, splatting {}\n", name(draw_.instancing),
               name(draw_.splatting));
  }

  void update_title(GLFWwindow* window) {
    if (!statistics_ && !title_stale_) return;
    title_stale_ = false;
    count();
    const std::string name = "Pointreel: " + reel_->manifest().name;
    glfwSetWindowTitle(window, (statistics_ ? name + ": " + report_.to_title() : name).c_str());
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
  std::unique_ptr<ReelPlayback> reel_;
  std::optional<Renderer> renderer_;
  Camera camera_;
  PlayReport report_;
  std::shared_ptr<const SceneFrame> shown_;
  std::optional<steady_clock::time_point> started_;
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
