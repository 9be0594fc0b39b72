#include "client/playback/reel_playback.h"

#include <algorithm>
#include <thread>
#include <utility>

#include "client/playback/prepare.h"

namespace pointreel {
namespace {

Timeline timeline_of(const Manifest& manifest) {
  Timeline timeline;
  for (const Segment& segment : manifest.segments)
    timeline.times_us.insert(timeline.times_us.end(), segment.times_us.begin(),
                             segment.times_us.end());
  timeline.duration_us = std::max<std::uint64_t>(manifest.duration_us, 1);
  return timeline;
}

FrameBuffer::Options buffer_options(const Manifest& manifest,
                                    const ReelPlayback::Options& options) {
  return {manifest.frame_count(),
          options.single_frame ? 0u
          : options.remote     ? 16u
                               : 4u,
          options.loop, options.mode};
}

}  // namespace

ReelPlayback::ReelPlayback(std::unique_ptr<Source> source, const Options& options,
                           const Camera& camera, glm::ivec2 size, Pipeline::OnError on_error)
    : source_(std::move(source)),
      options_(options),
      clock_(timeline_of(source_->manifest()), options.loop),
      buffer_(buffer_options(source_->manifest(), options)),
      mode_(options.mode) {
  const Clock::TimePoint now{};
  clock_.set_speed(options.speed, now);
  clock_.seek(options.start_us, now);
  jump(now, 1);
  look(camera, size);
  const unsigned cores = std::max(1u, std::thread::hardware_concurrency());
  // Over a network the frames under way hide each other's round trips.
  const Pipeline::Options threads{options.remote ? 4u : 1u, std::min(cores, 8u)};
  pipeline_.emplace(
      *source_, buffer_,
      [this](const FrameRequest& frame) {
        FetchRequest request = layer_choice(manifest(), frame.mode, frame.level);
        request.layers = std::min(request.layers, options_.layers);
        return request;
      },
      [this](const FrameRequest& frame, const FetchedFrame& fetched) {
        auto scene = prepare_frame(manifest(), frame.frame, fetched,
                                   {frame.mode, options_.delta, frame.level});
        if (scene && frame.mode == DrawMode::voxel) {
          voxel_depth_.learn(*scene);
          set_level();
        }
        return scene;
      },
      std::move(on_error), threads);
}

void ReelPlayback::look(const Camera& camera, glm::ivec2 size) {
  if (camera_ != camera || size_ != size) {
    camera_ = camera;
    size_ = size;
    view_level_ = level_for(manifest(), camera, size, options_.pixel_size);
  }
  set_level();
}

void ReelPlayback::set_level() {
  const int level = view_level_;
  buffer_.set_level(mode_ == DrawMode::voxel ? std::min(level, voxel_depth_.get()) : level);
}

void ReelPlayback::set_mode(DrawMode mode) {
  mode_ = mode;
  buffer_.set_mode(mode);
  given_ordinal_.reset();
}

FetchRequest ReelPlayback::choice(int level) const {
  return layer_choice(manifest(), mode_, level);
}

void ReelPlayback::jump(Clock::TimePoint now, int direction) {
  playhead_ = clock_.read(now).frame;
  buffer_.seek(playhead_, direction);
  given_ordinal_.reset();
}

void ReelPlayback::toggle_play(Clock::TimePoint now) {
  if (clock_.playing()) {
    clock_.pause(now);
  } else {
    clock_.play(now);
    jump(now, 1);
  }
}

void ReelPlayback::seek_by(std::int64_t delta_us, Clock::TimePoint now) {
  clock_.seek_by(delta_us, now);
  jump(now, 1);
}

void ReelPlayback::step(std::int64_t frames, Clock::TimePoint now) {
  clock_.step(frames, now);
  jump(now, frames < 0 ? -1 : 1);
}

void ReelPlayback::toggle_loop(Clock::TimePoint now) {
  clock_.set_loop(!clock_.loop(), now);
  buffer_.set_loop(clock_.loop());
  given_ordinal_.reset();
}

ReelPlayback::Update ReelPlayback::update(Clock::TimePoint now) {
  if (!started_ && buffer_.wait(std::chrono::milliseconds(0)) != FrameBuffer::State::waiting) {
    started_ = true;
    clock_.play(now);
  }
  const Clock::Reading reading = clock_.read(now);
  if (reading.ended) {
    if (given_ordinal_) dropped_ += static_cast<std::uint64_t>(reading.ordinal - *given_ordinal_);
    return {given_, false, true};
  }
  if (reading.frame != playhead_) {
    playhead_ = reading.frame;
    buffer_.advance(reading.frame);
  }
  Update update{buffer_.best()};
  if (update.frame && update.frame != given_) {
    const std::optional<std::int64_t> before = given_ordinal_;
    count_dropped(*update.frame, reading);
    update.refined = given_ && before == given_ordinal_;
    given_ = update.frame;
  }
  return update;
}

/// Frames that lie between the one given before and this one.
void ReelPlayback::count_dropped(const SceneFrame& frame, const Clock::Reading& reading) {
  const std::int64_t count = timeline().frame_count();
  const std::int64_t late =
      (static_cast<std::int64_t>(reading.frame) - static_cast<std::int64_t>(frame.index) + count) %
      count;
  const std::int64_t ordinal = reading.ordinal - late;
  if (given_ordinal_ && ordinal > *given_ordinal_ + 1)
    dropped_ += static_cast<std::uint64_t>(ordinal - *given_ordinal_ - 1);
  given_ordinal_ = ordinal;
}

FrameBuffer::State ReelPlayback::await(std::uint32_t frame, std::chrono::milliseconds timeout) {
  buffer_.advance(frame);
  return buffer_.wait(timeout, true);
}

}  // namespace pointreel
