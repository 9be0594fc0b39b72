#include "client/app/offscreen_player.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <stop_token>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "client/app/bell.h"
#include "client/playback/opening.h"
#include "client/playback/stage.h"
#include "client/record/frame_plan.h"
#include "client/record/open_recorder.h"
#include "client/record/video_writer.h"
#include "client/render/make_renderer.h"
#include "client/session/console.h"
#include "client/session/presenter.h"
#include "client/session/stage_setup.h"
#include "client/sound/audio_passes.h"
#include "codec/audio/audio_time.h"
#include "common/base/try.h"
#include "common/file_system/output_folder.h"
#include "common/net/url.h"
#include "common/process/print.h"
#include "common/process/progress.h"

namespace pointreel {
namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;

std::uint64_t microseconds(double seconds) {
  return static_cast<std::uint64_t>(std::llround(seconds * 1e6));
}

/// How often the player looks for trouble to report, at least.
constexpr milliseconds kLookPeriod{100};

/// A server that has sent nothing for so long is not expected to go on before the duration ends.
constexpr std::chrono::seconds kSilence{5};

class OffscreenPlayer {
 public:
  OffscreenPlayer(const PlayOptions& options, const std::stop_token& stop)
      : options_(options), stop_(stop) {}

  Result<void> run() {
    if (!options_.record.empty()) TRY(check_recording(options_.record));
    stage_ = TRY(open_stage());
    if (!stage_) return stopped_without_picture();
    TRY(check_scalar_field(options_.settings, *stage_));
    OffscreenRenderer offscreen = TRY(make_offscreen_renderer(options_.settings.renderer));
    if (!offscreen.context) say_what_needs_opengl();
    presenter_ = std::make_unique<Presenter>(options_, std::move(offscreen.renderer));
    presenter_->begin(*stage_);
    presenter_->start_clock();
    camera_ = first_camera(options_, stage_->view_bounds(), stage_->up(), size_);

    auto ended = plays_every_frame()         ? play_every_frame(*stage_->reel(0))
                 : is_single_frame(options_) ? draw_one_picture()
                                             : play_in_real_time();
    if (plays_every_frame() || is_single_frame(options_))
      presenter_->count(*stage_, lost_);
    else
      presenter_->count(*stage_);
    recorder_.reset();  // before the stage, whose sound it may still read
    // Whoever interrupts it does not wait until large frames are decoded.
    if (stop_.stop_requested())
      retire(std::move(stage_));
    else
      stage_.reset();
    if (ended) ended = presenter_->write_report();
    presenter_.reset();  // before its context
    return ended;
  }

 private:
  void say_what_needs_opengl() const {
    const Instancing instancing = options_.settings.draw.instancing;
    if (instancing == Instancing::pull) return;  // the default
    print_error("pointreel", fmt::format("--instancing {} is a way of OpenGL and does nothing in "
                                         "software; --renderer opengl draws with it",
                                         name(instancing)));
  }

  /// A live stream has no end of its own, so that a player without a window would seem to hang.
  void say_what_ends_it() const {
    bool is_live = false;
    for (std::size_t i = 0; i < stage_->size(); ++i) is_live |= stage_->live(i) != nullptr;
    if (is_live && !options_.duration)
      print_error("pointreel", "playing until Ctrl-C; --duration SECONDS sets an end");
  }

  /// Null if it was stopped.
  Result<std::unique_ptr<Stage>> open_stage() {
    Stage::Options stage = stage_options(options_);
    stage.on_ready = [this] { bell_.ring(); };
    Opening opening(
        options_.sources, std::move(stage),
        [this](const Box& bounds, Up up) { return first_camera(options_, bounds, up, size_); },
        [this](std::size_t source, std::uint32_t frame, const Error& error) {
          const auto& sources = options_.sources;
          errors_.print(source,
                        sources.size() > 1 ? without_secrets(sources[source].where) + ": " : "",
                        frame, error);
        });
    while (!stop_.stop_requested()) {
      if (auto opened = opening.poll()) return std::move(*opened);
      const auto now = steady_clock::now();
      if (is_remote() && now >= patience_ends_) return given_up(opening.trouble());
      bell_.wait(std::min(now + kLookPeriod, patience_ends_), stop_);
    }
    return nullptr;
  }

  bool is_remote() const {
    return std::any_of(options_.sources.begin(), options_.sources.end(),
                       [](const auto& source) { return !scheme_of(source.where).empty(); });
  }

  /// The error if a server has brought nothing by the time that is allowed.
  tl::unexpected<Error> given_up(const std::optional<std::string>& trouble) const {
    Error error = nothing_came(options_);
    if (trouble) error.message += " (" + *trouble + ")";
    return tl::unexpected(std::move(error));
  }

  /// A single reel needs no clock; several sources do, to stay together.
  bool plays_every_frame() const { return stage_->size() == 1 && stage_->reel(0) != nullptr; }

  Result<void> draw(const std::vector<Stage::Change>& changes) {
    DrawOptions draw = options_.settings.draw;
    draw.refine = options_.settings.refine == Refine::automatic;
    draw.smooth_outlines = options_.settings.smooth_outlines;
    if (options_.settings.floor) draw.floor = floor_under(*stage_, camera_);
    return presenter_->draw(*stage_, changes, {camera_, size_, draw, {}});
  }

  Camera camera_at(std::uint64_t time_us) const {
    const Up up = options_.settings.up.value_or(stage_->up());
    return pointreel::camera_at(options_, time_us, stage_->view_bounds(), up, size_);
  }

  /// Whether there is more, or less, to see than at the last call.
  bool has_new_view() {
    return std::exchange(view_version_, stage_->view_version()) != view_version_;
  }

  /// Whether that is another camera.
  bool look(const Camera& camera) {
    if (camera == camera_) return false;
    camera_ = camera;
    kept_.clear();
    stage_->look(camera_, size_);
    return true;
  }

  /// Of several reels, at the same time.
  Result<void> draw_one_picture() {
    TRY(open_recording(std::nullopt, std::nullopt));
    std::vector<std::uint32_t> frames;
    std::uint64_t end_us = 0;
    stage_->for_each_reel([&](const ReelPlayback& reel) {
      const FramePlan plan(reel.timeline(), start_us(options_), std::nullopt, false);
      frames.push_back(plan.picture(0).frame);
      end_us = std::max(end_us, plan.picture(1).time_us);
    });
    std::vector<Stage::Change> changes;
    // The first frames may show that the bounds are much too large. They are then needed in more
    // detail, which may show that again.
    do {
      changes.clear();
      lost_ = 0;
      for (std::size_t i = 0; i < frames.size(); ++i) {
        ReelPlayback& reel = *stage_->reel(i);
        const FrameBuffer::State state = await(reel, frames[i]);
        if (stop_.stop_requested()) return stopped_without_picture();
        if (state == FrameBuffer::State::ready)
          std::ranges::copy(stage_->take(i, reel.best()), std::back_inserter(changes));
        else
          ++lost_;
      }
    } while (has_new_view() && look(camera_at(start_us(options_))));
    if (lost_ == 0) {
      TRY(draw(changes));
      TRY(record(0));
    }
    return finish(end_us);
  }

  Result<void> play_every_frame(ReelPlayback& reel) {
    std::optional<std::uint64_t> duration_us;
    if (options_.duration) duration_us = microseconds(*options_.duration);
    const FramePlan plan(reel.timeline(), start_us(options_), duration_us,
                         options_.settings.loop.value_or(false));
    std::uint64_t count = plan.count().value_or(std::numeric_limits<std::uint64_t>::max());
    if (is_single_frame(options_)) count = std::min<std::uint64_t>(count, 1);
    TRY(open_recording(plan.rate(), TRY(sound_of(reel, plan, count))));
    if (plan.count() && count > 1) {
      progress_.emplace(recorder_ ? "record" : "draw", static_cast<std::size_t>(count));
      errors_.set_progress(&*progress_);
    }
    const auto drawn = draw_frames(plan, count, reel);
    errors_.set_progress(nullptr);
    progress_.reset();
    if (!drawn) return tl::unexpected(drawn.error());
    return finish(plan.picture(*drawn).time_us);
  }

  /// How many pictures were drawn.
  Result<std::uint64_t> draw_frames(const FramePlan& plan, std::uint64_t count,
                                    ReelPlayback& reel) {
    std::uint64_t i = 0;
    for (; i < count && !stop_.stop_requested(); ++i) {
      const FramePlan::Picture picture = plan.picture(i);
      if (options_.camera_path) look(camera_at(picture.reel_time_us));
      FrameBuffer::State state = await(reel, picture.frame);
      if (state == FrameBuffer::State::waiting && stop_.stop_requested()) break;
      if (state == FrameBuffer::State::waiting) return given_up(reel.trouble());
      if (state == FrameBuffer::State::ready) {
        std::vector<Stage::Change> changes = stage_->take(0, reel.best());
        // The first frame may show that the bounds are much too large. It is then needed in more
        // detail, which may show that again.
        while (has_new_view() && look(camera_at(picture.reel_time_us)) &&
               await(reel, picture.frame) == FrameBuffer::State::ready)
          changes = stage_->take(0, reel.best());
        shown_frame_ = picture.frame;
        if (kept_.contains(picture.frame))
          presenter_->repeat(*stage_, changes);
        else
          TRY(draw(changes));
      } else {
        ++lost_;  // the last picture stays
      }
      TRY(record(picture.time_us));
      if (progress_) progress_->tick();
    }
    return i;
  }

  /// The sound of a recording of the first `count` pictures.
  Result<std::optional<RecordedSound>> sound_of(const ReelPlayback& reel, const FramePlan& plan,
                                                std::uint64_t count) {
    const std::optional<AudioFile>& audio = reel.manifest().audio;
    if (!audio || !options_.audio || !is_video(options_.record)) return std::nullopt;
    const auto fetch = [&reel](std::uint64_t offset, std::uint64_t size,
                               const std::stop_token& stop) {
      return reel.fetch_audio(offset, size, stop);
    };
    auto opened = AudioPasses::open(*audio, fetch, reel.manifest().duration_us, stop_);
    if (!opened)
      return fail(opened.error().code, fmt::format("{}: sound: {}; --no-audio records without it",
                                                   stage_->where(0), opened.error().message));
    RecordedSound sound;
    // Called once a picture has been recorded.
    sound.read = [this, begin_us = plan.picture(0).reel_time_us,
                  passes = std::make_shared<AudioPasses>(*std::move(opened))](
                     std::uint64_t first, std::span<StereoSample> samples) {
      return passes->read(first_sample_from(begin_us + *first_recorded_us_) + first, samples);
    };
    if (plan.count()) sound.end_us = plan.picture(count).time_us;
    return sound;
  }

  /// Waits until the frame is ready or has failed. It is still waiting if playing was stopped, or
  /// if the duration has passed and nothing comes over the network any more.
  FrameBuffer::State await(ReelPlayback& reel, std::uint32_t frame) {
    FrameBuffer::State state = FrameBuffer::State::waiting;
    std::uint64_t fetched = 0;
    auto silent_since = steady_clock::now();
    while (state == FrameBuffer::State::waiting && !stop_.stop_requested()) {
      state = reel.await(frame, milliseconds(50));
      troubles_.look(*stage_, progress_ ? &*progress_ : nullptr);
      const auto now = steady_clock::now();
      if (std::exchange(fetched, reel.statistics().fetched_bytes) != fetched) silent_since = now;
      if (options_.duration && now >= patience_ends_ && is_remote() &&
          (fetched == 0 || now - silent_since >= kSilence))
        break;
    }
    return state;
  }

  Result<void> play_in_real_time() {
    TRY(open_recording(std::nullopt, std::nullopt));
    bool is_first = true;
    auto last_look = steady_clock::now();
    while (!stop_.stop_requested()) {
      const auto now = steady_clock::now();
      const std::uint64_t time_us = microseconds(presenter_->seconds());
      if (now >= end_of_duration(options_)) {
        if (!presenter_->shown()) return tl::unexpected(nothing_came(options_));
        break;
      }
      const Stage::Update update = stage_->update(now);
      if (auto why = stage_->refusal()) return tl::unexpected(*std::move(why));
      if (update.ended) break;
      if (has_new_view() || options_.camera_path) camera_ = camera_at(start_us(options_) + time_us);
      stage_->look(camera_, size_);
      if (!update.changes.empty()) {
        TRY(draw(update.changes));
        TRY(record(time_us));
        if (std::exchange(is_first, false)) say_what_ends_it();
      }
      if (now - last_look >= kLookPeriod) {
        last_look = now;
        troubles_.look(*stage_);
      }
      bell_.wait(next_round(now, update), stop_);
    }
    return finish(microseconds(presenter_->seconds()));
  }

  /// The time at which there is something to do even if the bell does not ring.
  steady_clock::time_point next_round(steady_clock::time_point now,
                                      const Stage::Update& update) const {
    const auto next = std::min(now + kLookPeriod, update.due.value_or(now + kLookPeriod));
    return std::min(next, end_of_duration(options_));
  }

  Result<void> open_recording(const std::optional<FrameRate>& rate,
                              std::optional<RecordedSound> sound) {
    if (!options_.record.empty())
      recorder_ = TRY(open_recorder(options_.record, size_, rate, std::move(sound)));
    return {};
  }

  /// Adds the picture shown, if any, to the recording, which begins at the time of the first one.
  Result<void> record(std::uint64_t time_us) {
    if (!recorder_ || !presenter_->shown()) return {};
    if (!first_recorded_us_) first_recorded_us_ = time_us;
    time_us -= *first_recorded_us_;
    if (const auto kept = kept_.find(shown_frame_); kept != kept_.end())
      return recorder_->add(kept->second, time_us);
    Image picture = TRY(presenter_->painter().picture());
    TRY(recorder_->add(picture, time_us));
    if (repeats() && kept_.size() < most_kept(picture))
      kept_.emplace(shown_frame_, std::move(picture));
    return {};
  }

  /// Whether frames are shown again, and look the same.
  bool repeats() const {
    return plays_every_frame() && options_.settings.loop.value_or(false) && !options_.camera_path;
  }
  std::size_t most_kept(const Image& picture) const {
    return (options_.cache << 20) / (sizeof(picture.pixels[0]) * picture.pixels.size());
  }

  /// The last picture is shown until `end_us`, on the clock of record().
  Result<void> finish(std::uint64_t end_us) {
    if (presenter_->shown()) TRY(write_files(end_us));
    if (stop_.stop_requested())
      return presenter_->shown() ? Result<void>() : stopped_without_picture();
    auto missing = nothing_shown(*stage_);
    if (missing) return tl::unexpected(*std::move(missing));
    return {};
  }

  /// An error if a file was to be written.
  Result<void> stopped_without_picture() const {
    if (options_.screenshot.empty() && options_.record.empty()) return {};
    return fail(ErrorCode::cancelled, kInterrupted);
  }

  Result<void> write_files(std::uint64_t end_us) {
    if (recorder_) TRY(recorder_->finish(end_us - first_recorded_us_.value_or(end_us)));
    if (options_.screenshot.empty()) return {};
    const auto kept = kept_.find(shown_frame_);
    return kept != kept_.end() ? write_png(options_.screenshot, kept->second)
                               : presenter_->painter().write(options_.screenshot);
  }

  const PlayOptions& options_;
  const std::stop_token stop_;
  const glm::ivec2 size_ = options_.picture_size();
  /// However short the recording, links over satellites take seconds until something comes.
  const steady_clock::time_point patience_ends_ =
      std::max(end_of_duration(options_), options_.started + std::chrono::seconds(5));
  Bell bell_;
  std::optional<Progress> progress_;
  ErrorLines errors_;
  TroubleLines troubles_;
  std::unique_ptr<Stage> stage_;
  std::unique_ptr<Presenter> presenter_;
  Camera camera_;
  std::size_t view_version_ = 0;  ///< of the stage, at the last look
  std::uint64_t lost_ = 0;        ///< broken frames that were skipped
  std::unique_ptr<Recorder> recorder_;
  std::optional<std::uint64_t> first_recorded_us_;
  std::uint32_t shown_frame_ = 0;  ///< while every frame is played
  /// Recorded pictures of frames that will be shown again, and are then not drawn again.
  std::map<std::uint32_t, Image> kept_;
};

}  // namespace

Result<void> play_offscreen(const PlayOptions& options, const std::stop_token& stop) {
  return OffscreenPlayer(options, stop).run();
}

}  // namespace pointreel
