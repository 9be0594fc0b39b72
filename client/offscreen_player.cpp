#include "client/offscreen_player.h"

#include <chrono>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <thread>
#include <utility>

#include "client/capture.h"
#include "client/console.h"
#include "client/playback/stage.h"
#include "client/presenter.h"
#include "client/render/gl_context.h"

namespace pointreel {
namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;

std::uint64_t microseconds(double seconds) {
  return static_cast<std::uint64_t>(std::llround(seconds * 1e6));
}

class OffscreenPlayer {
 public:
  OffscreenPlayer(const PlayOptions& options, const std::stop_token& stop)
      : options_(options), stop_(stop) {}

  Result<void> run() {
    auto stage = Stage::open(
        options_.sources, stage_options(options_),
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
    return presenter_->show(*stage_, changes, camera_, options_.size, options_.draw);
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
    for (std::uint64_t ordinal = first; !stop_.stop_requested(); ++ordinal) {
      if (ordinal >= count && !loop) break;
      const auto frame = static_cast<std::uint32_t>(ordinal % count);
      const std::uint64_t time_us =
          ordinal / count * timeline.duration_us + timeline.times_us[frame] - start_us;
      if (time_us >= end_us) break;
      FrameBuffer::State state = FrameBuffer::State::waiting;
      while (state == FrameBuffer::State::waiting && !stop_.stop_requested()) {
        state = reel.await(frame, milliseconds(50));
        trouble_.look(*stage_);
      }
      if (state == FrameBuffer::State::ready) {
        if (auto drawn = show(stage_->take(0, reel.best())); !drawn) return drawn;
      } else if (state == FrameBuffer::State::failed) {
        ++lost_;
      } else {
        break;
      }
      if (auto written = record(); !written) return written;
      if (single_frame(options_)) break;
    }
    if (!presenter_->shown() && !stop_.stop_requested())
      return fail(options_.sources[0].where + ": no frame could be shown");
    return last_screenshot();
  }

  Result<void> play_in_real_time() {
    std::size_t bounded = 0;
    auto last_look = steady_clock::now();
    while (!stop_.stop_requested()) {
      std::this_thread::sleep_for(milliseconds(1));
      if (options_.duration && presenter_->shown() && presenter_->seconds() >= *options_.duration)
        break;
      const Stage::Update update = stage_->update(steady_clock::now());
      if (update.ended) break;
      // Live streams say late where they are.
      if (stage_->bounded() != bounded) {
        bounded = stage_->bounded();
        camera_ = first_camera(options_, stage_->bounds(), stage_->up(), options_.size);
      }
      stage_->look(camera_, options_.size);
      if (!update.changes.empty()) {
        if (auto drawn = show(update.changes); !drawn) return drawn;
        if (auto written = record(); !written) return written;
      }
      if (steady_clock::now() - last_look > milliseconds(100)) {
        last_look = steady_clock::now();
        trouble_.look(*stage_);
      }
    }
    return last_screenshot();
  }

  Result<void> record() {
    if (options_.record.empty() || !presenter_->shown()) return {};
    return presenter_->painter().write(NumberedPath::parse(options_.record)->at(recorded_++));
  }

  Result<void> last_screenshot() {
    if (options_.screenshot.empty() || !presenter_->shown()) return {};
    return presenter_->painter().write(options_.screenshot);
  }

  const PlayOptions& options_;
  const std::stop_token stop_;
  ErrorLines errors_;
  TroubleLines trouble_;
  std::unique_ptr<Stage> stage_;
  std::unique_ptr<Presenter> presenter_;
  Camera camera_;
  std::uint64_t lost_ = 0;  ///< frames that were skipped for being broken
  std::uint64_t recorded_ = 0;
};

}  // namespace

Result<void> play_offscreen(const PlayOptions& options, const std::stop_token& stop) {
  return OffscreenPlayer(options, stop).run();
}

}  // namespace pointreel
