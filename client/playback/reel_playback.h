#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include <glm/glm.hpp>

#include "client/playback/buffer.h"
#include "client/playback/clock.h"
#include "client/playback/layer_choice.h"
#include "client/playback/pipeline.h"
#include "client/playback/playback.h"
#include "client/scene/camera.h"
#include "client/scene/frame.h"
#include "client/source/source.h"

namespace pointreel {

/// Everything that plays one reel: where its frames come from, what time it is, what is fetched and
/// decoded for the view, and the frames that are ready.
class ReelPlayback : public Playback {
 public:
  struct Options {
    DrawMode mode = DrawMode::surfel;
    double delta = 0.7;          ///< PrepareOptions::delta
    std::uint32_t layers = ~0u;  ///< no more are fetched, however near the camera
    float pixel_size = 1.0f;     ///< DrawOptions::pixel_size
    bool loop = true;
    double speed = 1.0;
    std::uint64_t start_us = 0;
    bool remote = false;  ///< round trips take time: more frames are fetched at once, and ahead
    bool single_frame = false;  ///< only the first one will be asked for
  };

  /// Begins to fetch what the camera shows in a picture of `size` pixels. The source has at least
  /// one frame. `on_error`: Pipeline::OnError.
  ReelPlayback(std::unique_ptr<Source> source, const Options& options, const Camera& camera,
               glm::ivec2 size, Pipeline::OnError on_error);

  const Manifest& manifest() const { return source_->manifest(); }
  const Timeline& timeline() const { return clock_.timeline(); }

  const std::string& name() const override { return manifest().name; }
  char up() const override { return manifest().up; }
  Box bounds() const override { return manifest().bounds; }
  void look(const Camera& camera, glm::ivec2 size) override;
  void set_mode(DrawMode mode) override;
  Update update(Clock::TimePoint now) override;
  std::optional<std::string> trouble() const override { return source_->trouble(); }
  std::uint64_t dropped() const override { return dropped_; }
  std::uint64_t errors() const override { return pipeline_->errors(); }

  /// What is fetched of frames that have `level`, for the mode of now.
  FetchRequest choice(int level) const;

  // Time. Stands still, as if paused, until the first frame is there.

  void toggle_play(Clock::TimePoint now);
  void seek_by(std::int64_t delta_us, Clock::TimePoint now);
  void step(std::int64_t frames, Clock::TimePoint now);
  void set_speed(double speed, Clock::TimePoint now) { clock_.set_speed(speed, now); }
  void toggle_loop(Clock::TimePoint now);
  bool playing() const { return clock_.playing(); }
  double speed() const { return clock_.speed(); }

  // Without a clock: frames in any order, each as soon as it is there.

  /// Goes to `frame` and waits for it, with all the levels that are seen, at most for `timeout`.
  FrameBuffer::State await(std::uint32_t frame, std::chrono::milliseconds timeout);
  std::shared_ptr<const SceneFrame> best() const { return buffer_.best(); }

 private:
  void set_level();
  void jump(Clock::TimePoint now, int direction);
  void count_dropped(const SceneFrame& frame, const Clock::Reading& reading);

  const std::unique_ptr<Source> source_;
  const Options options_;
  Clock clock_;
  bool started_ = false;  ///< the first frame came, or failed
  FrameBuffer buffer_;
  std::atomic<DrawMode> mode_;
  std::uint32_t playhead_ = 0;
  std::optional<Camera> camera_;  ///< what view_level_ was found for
  glm::ivec2 size_{0};
  std::atomic<int> view_level_{kWholeFrame};  ///< the finest level that the camera can show
  VoxelDepth voxel_depth_;
  std::shared_ptr<const SceneFrame> given_;
  std::optional<std::int64_t> given_ordinal_;  ///< none after a jump
  std::uint64_t dropped_ = 0;
  std::optional<Pipeline> pipeline_;  ///< last: its threads use what is above
};

}  // namespace pointreel
