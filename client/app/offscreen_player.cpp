#include "client/app/offscreen_player.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <cstdint>
#include <limits>
#include <memory>
#include <mutex>
#include <optional>
#include <stop_token>
#include <utility>

#include "client/playback/stage.h"
#include "client/record/frame_plan.h"
#include "client/record/open_recorder.h"
#include "client/render/gl_context.h"
#include "client/session/console.h"
#include "client/session/presenter.h"
#include "common/base/progress.h"

namespace pointreel {
namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;

std::uint64_t microseconds(double seconds) {
  return static_cast<std::uint64_t>(std::llround(seconds * 1e6));
}

/// Wakes a thread that waits for anything to happen.
class Bell {
 public:
  void ring() {
    {
      const std::lock_guard lock(mutex_);
      rung_ = true;
    }
    changed_.notify_one();
  }
  /// Returns when it has been rung since the last wait, at `until`, or when `stop` is requested.
  void wait(steady_clock::time_point until, const std::stop_token& stop) {
    std::unique_lock lock(mutex_);
    changed_.wait_until(lock, stop, until, [this] { return rung_; });
    rung_ = false;
  }

 private:
  std::mutex mutex_;
  std::condition_variable_any changed_;
  bool rung_ = false;
};

/// How often it is said what the player waits for, if it does.
constexpr milliseconds kLook{100};

class OffscreenPlayer {
 public:
  OffscreenPlayer(const PlayOptions& options, const std::stop_token& stop)
      : options_(options), stop_(stop) {}

  Result<void> run() {
    if (!options_.record.empty()) {
      if (auto checked = check_recording(options_.record); !checked) return checked;
    }
    Stage::Options stage_options = pointreel::stage_options(options_);
    stage_options.on_ready = [this] { bell_.ring(); };
    auto stage = Stage::open(
        options_.sources, stage_options,
        [this](const Box& bounds, char up) {
          return first_camera(options_, bounds, up, options_.size);
        },
        [this](std::size_t source, std::uint32_t frame, const Error& error) {
          const auto& sources = options_.sources;
          errors_.print(source, sources.size() > 1 ? sources[source].where + ": " : "", frame,
                        error);
        });
    if (!stage) return tl::unexpected(stage.error());
    stage_ = *std::move(stage);
    auto context = OffscreenContext::create();
    if (!context) return tl::unexpected(context.error());
    auto presenter = Presenter::create(options_);
    if (!presenter) return tl::unexpected(presenter.error());
    presenter_ = *std::move(presenter);
    presenter_->begin(*stage_);
    presenter_->start_clock();
    camera_ = first_camera(options_, stage_->bounds(), stage_->up(), options_.size);

    auto ended = every_frame() ? play_every_frame(*stage_->reel(0)) : play_in_real_time();
    presenter_->report(*stage_, lost_, every_frame());
    stage_.reset();
    if (ended) ended = presenter_->write_report();
    presenter_.reset();  // before its context
    return ended;
  }

 private:
  /// Nothing has a time of its own.
  bool every_frame() const { return stage_->size() == 1 && stage_->reel(0) != nullptr; }

  Result<void> show(const std::vector<Stage::Change>& changes) {
    DrawOptions draw = options_.draw;
    if (options_.floor) draw.floor = floor_under(*stage_, camera_);
    return presenter_->show(*stage_, changes, camera_, options_.size, draw, {});
  }

  Camera camera_at(std::uint64_t time_us) const {
    return pointreel::camera_at(options_, time_us, stage_->bounds(), stage_->up(), options_.size);
  }

  Result<void> play_every_frame(ReelPlayback& reel) {
    std::optional<std::uint64_t> duration_us;
    if (options_.duration) duration_us = microseconds(*options_.duration);
    const FramePlan plan(reel.timeline(), start_us(options_), duration_us,
                         options_.loop.value_or(false));
    std::uint64_t count = plan.count().value_or(std::numeric_limits<std::uint64_t>::max());
    if (single_frame(options_)) count = std::min<std::uint64_t>(count, 1);
    if (auto opened = open(plan.rate()); !opened) return opened;
    if (plan.count() && count > 1) {
      progress_.emplace(recorder_ ? "record" : "draw", static_cast<std::size_t>(count));
      errors_.set_progress(&*progress_);
    }
    auto drawn = draw(plan, count, reel);
    errors_.set_progress(nullptr);
    progress_.reset();
    if (!drawn) return drawn;
    if (!presenter_->shown() && !stop_.stop_requested())
      return fail(options_.sources[0].where + ": no frame could be shown");
    return end();
  }

  Result<void> draw(const FramePlan& plan, std::uint64_t count, ReelPlayback& reel) {
    for (std::uint64_t i = 0; i < count && !stop_.stop_requested(); ++i) {
      const FramePlan::Picture picture = plan.picture(i);
      if (options_.camera_path) {
        camera_ = camera_at(picture.reel_time_us);
        stage_->look(camera_, options_.size);
      }
      FrameBuffer::State state = FrameBuffer::State::waiting;
      while (state == FrameBuffer::State::waiting && !stop_.stop_requested()) {
        state = reel.await(picture.frame, milliseconds(50));
        trouble_.look(*stage_, progress_ ? &*progress_ : nullptr);
      }
      if (state == FrameBuffer::State::ready) {
        if (auto drawn = show(stage_->take(0, reel.best())); !drawn) return drawn;
      } else if (state == FrameBuffer::State::failed) {
        ++lost_;  // and the picture stays
      } else {
        break;
      }
      if (auto recorded = record(picture.time_us); !recorded) return recorded;
      if (progress_) progress_->tick();
    }
    return {};
  }

  Result<void> play_in_real_time() {
    if (auto opened = open(std::nullopt); !opened) return opened;
    std::size_t bounded = 0;
    auto last_look = steady_clock::now();
    while (!stop_.stop_requested()) {
      const auto now = steady_clock::now();
      const std::uint64_t time_us = microseconds(presenter_->seconds());
      if (options_.duration && presenter_->shown() && time_us >= microseconds(*options_.duration))
        break;
      const Stage::Update update = stage_->update(now);
      if (update.ended) break;
      // Live streams say late where they are.
      if (stage_->bounded() != bounded || options_.camera_path) {
        bounded = stage_->bounded();
        camera_ = camera_at(start_us(options_) + time_us);
      }
      stage_->look(camera_, options_.size);
      if (!update.changes.empty()) {
        if (auto drawn = show(update.changes); !drawn) return drawn;
        if (auto recorded = record(time_us); !recorded) return recorded;
      }
      if (now - last_look > kLook) {
        last_look = now;
        trouble_.look(*stage_);
      }
      bell_.wait(next_round(now, update), stop_);
    }
    return end();
  }

  /// When there is something to do even if nothing happens.
  steady_clock::time_point next_round(steady_clock::time_point now,
                                      const Stage::Update& update) const {
    auto next = std::min(now + kLook, update.due.value_or(now + kLook));
    if (options_.duration && presenter_->shown()) {
      const double left = std::max(0.0, *options_.duration - presenter_->seconds());
      next = std::min(next, now + std::chrono::ceil<steady_clock::duration>(
                                      std::chrono::duration<double>(left)));
    }
    return next;
  }

  Result<void> open(const std::optional<FrameRate>& rate) {
    if (options_.record.empty()) return {};
    auto recorder = open_recorder(options_.record, options_.size, rate);
    if (!recorder) return tl::unexpected(recorder.error());
    recorder_ = *std::move(recorder);
    return {};
  }

  /// The picture shown; the first one's time is where the recording begins.
  Result<void> record(std::uint64_t time_us) {
    if (!recorder_ || !presenter_->shown()) return {};
    const auto picture = presenter_->painter().picture();
    if (!picture) return tl::unexpected(picture.error());
    if (!first_recorded_us_) first_recorded_us_ = time_us;
    return recorder_->add(*picture, time_us - *first_recorded_us_);
  }

  Result<void> end() {
    if (recorder_ && presenter_->shown()) {
      if (auto finished = recorder_->finish(); !finished) return finished;
    }
    return last_screenshot();
  }

  Result<void> last_screenshot() {
    if (options_.screenshot.empty() || !presenter_->shown()) return {};
    return presenter_->painter().write(options_.screenshot);
  }

  const PlayOptions& options_;
  const std::stop_token stop_;
  Bell bell_;
  std::optional<Progress> progress_;
  ErrorLines errors_;
  TroubleLines trouble_;
  std::unique_ptr<Stage> stage_;
  std::unique_ptr<Presenter> presenter_;
  Camera camera_;
  std::uint64_t lost_ = 0;  ///< frames that were skipped for being broken
  std::unique_ptr<Recorder> recorder_;
  std::optional<std::uint64_t> first_recorded_us_;
};

}  // namespace

Result<void> play_offscreen(const PlayOptions& options, const std::stop_token& stop) {
  return OffscreenPlayer(options, stop).run();
}

}  // namespace pointreel
