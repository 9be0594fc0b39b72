#include "client/playback/reel_playback.h"

#include <algorithm>
#include <cmath>
#include <thread>
#include <utility>

#include "client/playback/reel_layers.h"
#include "client/prepare/prepare.h"
#include "common/base/try.h"

namespace pointreel {
namespace {

Timeline timeline_of(const Manifest& manifest) {
  Timeline timeline;
  for (const Segment& segment : manifest.segments)
    timeline.times_us.insert(timeline.times_us.end(), segment.times_us.begin(),
                             segment.times_us.end());
  timeline.duration_us = std::max<std::uint64_t>(manifest.duration_us, 1);
  timeline.shown = shown_frames(manifest);
  return timeline;
}

// For a remote reel, in seconds of playing.
constexpr double kFetchAhead = 2.0;  ///< how far ahead frames are fetched
constexpr double kNear = 0.5;        ///< how far ahead bases come before the rest of any frame
constexpr double kLead = 0.1;        ///< how long before its time a frame is not refined any more
constexpr double kResume = 0.1;      ///< how much must have come to go on after a stall

/// How many frames are played in this time at this speed.
std::uint32_t frames_in(const Manifest& manifest, double seconds, double speed) {
  const double frames = std::ceil(seconds * manifest.fps * std::abs(speed));
  return static_cast<std::uint32_t>(std::clamp(frames, 1.0, 1e6));
}

/// How often it reconsiders what to fetch while it plays.
constexpr std::chrono::milliseconds kReconsider{50};

unsigned prepare_threads() { return std::clamp(std::thread::hardware_concurrency(), 1u, 8u); }

FrameBuffer::Options buffer_options(const Manifest& manifest,
                                    const ReelPlayback::Options& options) {
  FrameBuffer::Options buffer;
  buffer.frame_count = manifest.frame_count();
  buffer.ahead = options.single_frame ? 0u : options.remote ? 8u : 4u;
  buffer.loop = options.loop;
  buffer.mode = options.prepare.mode;
  buffer.levels = levels_of(manifest);
  buffer.cache_bytes = options.cache_bytes;
  if (options.remote && !options.single_frame) {
    buffer.fetch_ahead = frames_in(manifest, kFetchAhead, options.speed);
    buffer.near = frames_in(manifest, kNear, options.speed);
    buffer.store_bytes = options.store_bytes;
  }
  return buffer;
}

}  // namespace

ReelPlayback::ReelPlayback(std::unique_ptr<Source> source, const Options& options,
                           const Camera& camera, glm::ivec2 size, Pipeline::OnError on_error,
                           OnReady on_ready)
    : source_(std::move(source)),
      options_(options),
      on_ready_(std::move(on_ready)),
      clock_(timeline_of(source_->manifest()), options.loop),
      plan_(source_->manifest(), prepare_threads(), options.remote),
      buffer_([&] {
        FrameBuffer::Options buffer = buffer_options(source_->manifest(), options);
        buffer.choice = [this](std::uint32_t, DrawMode mode, int level) {
          PrepareOptions prepared = prepare_options();
          prepared.mode = mode;
          prepared.level = level;
          return plan_.decide(prepared).layers;
        };
        buffer.on_ready = on_ready_;
        return buffer;
      }()),
      prepare_(options.prepare) {
  const Clock::TimePoint now{};
  clock_.set_speed(options.speed, now);
  clock_.seek(options.start_us, now);
  jump(now, clock_.direction());
  look(camera, size);
  set_pace();
  // Over a link, several fetches at once hide each other's round trips.
  const Pipeline::Options threads{options.remote ? 6u : 1u, prepare_threads()};
  pipeline_.emplace(
      *source_, buffer_,
      [this](const FrameRequest& request, const FetchedFrame& fetched) {
        return prepare(request, fetched);
      },
      std::move(on_error), threads);
}

PrepareOptions ReelPlayback::prepare_options() const {
  const std::lock_guard lock(prepare_mutex_);
  return prepare_;
}

Result<SceneFrame> ReelPlayback::prepare(const FrameRequest& request, const FetchedFrame& fetched) {
  PrepareOptions options = prepare_options();
  options.mode = request.mode;
  options.level = request.level;
  std::shared_ptr<const StripRecord> record;
  {
    const std::lock_guard lock(prepare_mutex_);
    record = strip_record_;
  }
  auto scene = TRY(prepare_frame(
      fetched, frame_info(manifest(), request.frame), options,
      [&request] { return request.stop.stop_requested(); }, &record));
  // The octree below a video is whole by itself, but not all of the frame.
  if (manifest().codec == "video" && scene.layers == 1)
    scene.level = std::min(scene.level, kVideoBaseLevel);
  if (manifest().frame_count() > 1) {
    const std::lock_guard lock(prepare_mutex_);
    strip_record_ = std::move(record);
  }
  plan_.made(request.layers, scene.decode_ms + scene.normals_ms + scene.svo_ms);
  // A frame that lacks layers tells the depth only if it was given too few for it.
  const bool tells_depth = request.mode == DrawMode::voxel &&
                           (scene.level == kWholeFrame || scene.level >= voxel_depth_.get());
  if (!tells_depth) return scene;
  {
    const std::lock_guard lock(prepare_mutex_);
    if (options.delta != prepare_.delta) return scene;
    voxel_depth_.learn(scene);
  }
  set_level();
  return scene;
}

// What is fetched.

double ReelPlayback::frame_seconds() const {
  return 1.0 / (std::max(manifest().fps, 1e-3) * std::abs(clock_.speed()));
}

void ReelPlayback::set_pace() {
  FrameBuffer::Pace pace;
  if (options_.remote && !options_.single_frame) {
    pace.fetch_ahead = frames_in(manifest(), kFetchAhead, clock_.speed());
    pace.base_first = !awaiting_;
    if (clock_.playing() && !clock_.held())
      pace.lead = frames_in(manifest(), kLead, clock_.speed());
  }
  // A user who has jumped, looks at one frame, or sees nothing yet waits for that frame.
  pace.focus = !awaiting_ && (!given_ || !clock_.playing() || hold_ == Hold::jump);
  // A coarse picture is better than none, wherever the frames come from.
  pace.coarse_first = !awaiting_ && !given_;
  buffer_.set_pace(pace);
}

ReelPlayback::Statistics ReelPlayback::statistics() const {
  Statistics statistics = statistics_;
  statistics.fetched_bytes = pipeline_->fetched_bytes();
  statistics.refetched = pipeline_->refetched();
  statistics.reused = buffer_.reused();
  statistics.stored_bytes = buffer_.stored_bytes();
  statistics.frame_bytes = buffer_.held_bytes() + (thumbnails_ ? thumbnails_->bytes() : 0);
  statistics.buffered_seconds = fill_.fetched * frame_seconds();
  statistics.link_bits_per_second = 8.0 * plan_.bytes_per_second();
  return statistics;
}

/// Tells the plan how things stand, and the buffer if that changes what to fetch.
void ReelPlayback::update_plan(Clock::TimePoint now) {
  set_pace();
  const std::uint32_t window = std::max(1u, fill_.window);
  const std::uint32_t ahead = std::max(1u, fill_.ahead);
  LayerControl::Situation situation;
  situation.playing = (clock_.playing() || !started_) && !scrubbing_;
  situation.frame_seconds = frame_seconds();
  situation.fetched =
      fill_.full && fill_.fetched > fill_.ahead ? 1.0 : static_cast<double>(fill_.fetched) / window;
  situation.makeable = static_cast<double>(std::min(fill_.fetched, ahead)) / ahead;
  situation.made = static_cast<double>(fill_.made) / ahead;
  const PrepareOptions options = seen_options();
  if (plan_.update(now, std::move(situation), source_->link_use(), fill_.next, options))
    buffer_.choice_changed();
  if (!scrubbing_) plan_.note(fill_.next, options);
}

// What is looked at.

void ReelPlayback::look(const Camera& camera, glm::ivec2 size) {
  if (camera_ != camera || size_ != size) {
    camera_ = camera;
    size_ = size;
    view_level_ = level_for(manifest(), camera, size, prepare_options().pixel_size);
  }
  set_level();
}

/// As prepare_options(), down to the level that is seen.
PrepareOptions ReelPlayback::seen_options() const {
  PrepareOptions options = prepare_options();
  options.level = std::min<int>(options.level, view_level_);
  if (options.mode == DrawMode::voxel) options.level = std::min(options.level, voxel_depth_.get());
  if (!options.scalar.field.empty()) options.level = kWholeFrame;
  return options;
}

void ReelPlayback::set_level() {
  // One thread at a time, so that the newest level is the one that stays.
  const std::lock_guard lock(level_mutex_);
  buffer_.set_level(seen_options().level);
}

void ReelPlayback::set_prepare_options(const PrepareOptions& options) {
  const PrepareOptions before = prepare_options();
  if (options == before) return;
  const bool another_delta = options.delta != before.delta;
  {
    const std::lock_guard lock(prepare_mutex_);
    prepare_ = options;
    if (another_delta) voxel_depth_.forget();
  }
  if (options.pixel_size != before.pixel_size) camera_.reset();
  // Surfels are drawn from a package's own trees, whatever delta is, and points need no tree.
  const bool by_delta = options.mode == DrawMode::voxel ||
                        ((options.mode == DrawMode::surfel || options.mode == DrawMode::strip) &&
                         manifest().codec != "octree");
  const bool normals_come_or_go = options.show_normals != before.show_normals &&
                                  !draws_normals(options.mode, manifest().colors);
  const bool again = options.mode != before.mode || (another_delta && by_delta) ||
                     normals_come_or_go || options.scalar != before.scalar;
  if (again || another_delta) plan_.forget_made();
  set_level();
  if (options.layers != before.layers || options.scalar != before.scalar) buffer_.choice_changed();
  if (!again) return;
  buffer_.make_again(options.mode);
  given_ordinal_.reset();
}

LayerRange ReelPlayback::choice(int level) const {
  const PrepareOptions options = prepare_options();
  return layer_choice(manifest(), options.mode, level, options.show_normals,
                      !options.scalar.field.empty());
}

// Time.

void ReelPlayback::jump(Clock::TimePoint now, int direction) {
  playhead_ = clock_.read(now).frame;
  buffer_.seek(playhead_, direction);
  given_ordinal_.reset();
  scrubbing_ = false;
  if (!started_ || !clock_.playing()) return;
  clock_.hold(now);
  hold_ = Hold::jump;
}

void ReelPlayback::play(Clock::TimePoint now) {
  now = paced(now);
  begins_ = true;
  if (!started_ || clock_.playing()) return;
  clock_.play(now);
  jump(now, clock_.direction());
}

void ReelPlayback::pause(Clock::TimePoint now) {
  now = paced(now);
  begins_ = false;
  clock_.pause(now);
  release(now);
}

void ReelPlayback::seek(std::uint64_t time_us, Clock::TimePoint now) {
  now = paced(now);
  clock_.seek(time_us, now);
  jump(now, clock_.direction());
}

void ReelPlayback::seek_by(std::int64_t delta_us, Clock::TimePoint now) {
  now = paced(now);
  clock_.seek_by(delta_us, now);
  jump(now, clock_.direction());
}

void ReelPlayback::step(std::int64_t frames, Clock::TimePoint now) {
  now = paced(now);
  begins_ = false;
  clock_.step(frames, now);
  release(now);
  jump(now, frames < 0 ? -1 : 1);
}

void ReelPlayback::set_speed(double speed, Clock::TimePoint now) {
  now = paced(now);
  const int before = clock_.direction();
  clock_.set_speed(speed, now);
  if (clock_.direction() == before) return;
  given_ordinal_.reset();
  if (!scrubbing_) buffer_.advance(playhead_, clock_.direction());
}

void ReelPlayback::set_loop(bool loop, Clock::TimePoint now) {
  now = paced(now);
  clock_.set_loop(loop, now);
  buffer_.set_loop(loop);
  given_ordinal_.reset();
}

void ReelPlayback::set_loop_range(const std::optional<LoopRange>& range, Clock::TimePoint now) {
  now = paced(now);
  clock_.set_loop_range(range, now);
  buffer_.set_loop_range(clock_.loop_frames());
  given_ordinal_.reset();
}

void ReelPlayback::scrub_begin(Clock::TimePoint now) {
  if (scrubbing_) return;
  played_before_scrub_ = playing();
  pause(now);
  scrubbing_ = true;
  given_ordinal_.reset();
  buffer_.scrub(playhead_);
}

void ReelPlayback::scrub_to(std::uint64_t time_us, Clock::TimePoint now) {
  if (!scrubbing_) scrub_begin(now);
  now = paced(now);
  clock_.seek(time_us, now);
  const std::uint32_t frame = clock_.read(now).frame;
  if (frame == playhead_) return;
  playhead_ = frame;
  buffer_.scrub(frame);
}

void ReelPlayback::scrub_end(Clock::TimePoint now) {
  if (!scrubbing_) return;
  now = paced(now);
  begins_ = played_before_scrub_;
  if (begins_ && started_) clock_.play(now);
  jump(now, clock_.direction());
}

void ReelPlayback::release(Clock::TimePoint now) {
  if (hold_ == Hold::starved) {
    const double seconds = std::chrono::duration<double>(now - held_since_).count();
    ++statistics_.stalls;
    statistics_.stalled_seconds += seconds;
    statistics_.longest_stall_seconds = std::max(statistics_.longest_stall_seconds, seconds);
  }
  hold_ = Hold::none;
  clock_.release(now);
}

/// Waits for frames that the link does not bring in time.
void ReelPlayback::hold_if_starved(Clock::TimePoint now) {
  fill_ = buffer_.fill();
  if (hold_ == Hold::none) {
    if (!options_.remote || !started_ || !clock_.playing() || fill_.fetched > 0) return;
    clock_.hold(now);
    hold_ = Hold::starved;
    held_since_ = now;
    return;
  }
  const std::uint32_t enough =
      std::min(fill_.window, frames_in(manifest(), kResume, clock_.speed()));
  const bool there = hold_ == Hold::jump ? fill_.made > 0 : fill_.fetched >= enough;
  if (there) release(now);
}

ReelPlayback::Update ReelPlayback::update(Clock::TimePoint machine_now) {
  const Clock::TimePoint now = paced(machine_now);
  if (!started_ && buffer_.wait(std::chrono::milliseconds(0)) != FrameBuffer::State::waiting) {
    started_ = true;
    if (begins_ && !scrubbing_) clock_.play(now);
  }
  const Clock::Reading reading = clock_.read(now);
  if (reading.ended) {
    if (given_ordinal_)
      dropped_ += static_cast<std::uint64_t>(std::abs(reading.ordinal - *given_ordinal_));
    given_ordinal_.reset();
    return {given_, false, true};
  }
  if (reading.frame != playhead_) {
    playhead_ = reading.frame;
    buffer_.advance(reading.frame, clock_.direction());
  }
  // Taken before the clock may be released, which goes on with the frame that it was held for.
  Update update{started_ ? buffer_.best() : nullptr};
  hold_if_starved(now);
  // Thumbnails leave the link to the picture if that is waited for.
  if (thumbnails_) thumbnails_->set_quiet(fill_.fetched == 0);
  update_plan(now);
  if (update.frame && update.frame != given_) {
    if (scrubbing_) {
      update.refined = given_ && given_->index == update.frame->index;
    } else {
      const std::optional<std::int64_t> before = given_ordinal_;
      count_dropped(*update.frame, reading);
      update.refined = given_ && before == given_ordinal_;
    }
    given_ = update.frame;
  }
  // The two times differ by some, but hardly run apart until then.
  if (const auto next = due(now)) update.due = machine_now + (*next - now);
  return update;
}

/// Frames that come late are announced by OnReady.
std::optional<Clock::TimePoint> ReelPlayback::due(Clock::TimePoint now) const {
  if (started_ && !clock_.playing()) return std::nullopt;
  const Clock::TimePoint reconsider = now + kReconsider;
  return std::min(clock_.next_frame(now).value_or(reconsider), reconsider);
}

/// Counts the frames between the one given before and this one.
void ReelPlayback::count_dropped(const SceneFrame& frame, const Clock::Reading& reading) {
  const std::int64_t direction = clock_.direction();
  const PlayOrder order{timeline().frame_count(), clock_.loop(), clock_.direction(),
                        clock_.loop_frames()};
  const std::int64_t late = order.steps(frame.index, reading.frame).value_or(0);
  const std::int64_t ordinal = reading.ordinal - direction * late;
  if (given_ordinal_ && (ordinal - *given_ordinal_) * direction > 1)
    dropped_ += static_cast<std::uint64_t>((ordinal - *given_ordinal_) * direction - 1);
  given_ordinal_ = ordinal;
}

std::shared_ptr<const SceneFrame> ReelPlayback::thumbnail(std::uint32_t frame) {
  if (frame >= timeline().frame_count()) return nullptr;
  if (!thumbnails_)
    thumbnails_.emplace(
        *source_,
        [this](std::uint32_t index) {
          const LayerRange needs = layer_choice(manifest(), DrawMode::point, Thumbnails::kLevel);
          return buffer_.stored_base(index, needs.colors, needs.normals);
        },
        Thumbnails::kBytes, on_ready_);
  return thumbnails_->get(frame);
}

FrameBuffer::State ReelPlayback::await(std::uint32_t frame, std::chrono::milliseconds timeout) {
  if (!awaiting_) {
    awaiting_ = true;
    if (plan_.lift_limits()) buffer_.choice_changed();
    set_pace();
  }
  playhead_ = frame;
  buffer_.advance(frame);
  plan_.note(frame, seen_options());
  return buffer_.wait(timeout, true);
}

}  // namespace pointreel
