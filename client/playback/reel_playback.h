#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include <glm/glm.hpp>

#include "client/playback/buffer.h"
#include "client/playback/clock.h"
#include "client/playback/layer_plan.h"
#include "client/playback/paced_time.h"
#include "client/playback/pipeline.h"
#include "client/playback/playback.h"
#include "client/playback/thumbnails.h"
#include "client/prepare/layer_choice.h"
#include "client/prepare/prepare.h"
#include "client/scene/camera.h"
#include "client/scene/frame.h"
#include "client/source/source.h"

namespace pointreel {

/// Plays one reel. It knows where the reel's frames come from, what time it is, what is fetched and
/// decoded for the view, and which frames are ready.
class ReelPlayback : public Playback {
 public:
  struct Options {
    PrepareOptions prepare;
    bool loop = true;
    double speed = 1.0;
    std::uint64_t start_us = 0;
    bool remote = false;  ///< it comes over a link: more frames are fetched at once, and ahead
    bool single_frame = false;  ///< only the first frame will be shown
    /// How many bytes of a remote reel's coded frames are kept, besides those played next.
    std::uint64_t store_bytes = std::uint64_t{96} << 20;
    std::uint64_t cache_bytes = 0;  ///< FrameBuffer::Options::cache_bytes
    /// The time by which it plays; null: the machine's.
    std::shared_ptr<const PacedTime> time = {};
  };

  /// Begins to fetch what the camera shows in a picture of `size` pixels. The source must have at
  /// least one frame.
  ReelPlayback(std::unique_ptr<Source> source, const Options& options, const Camera& camera,
               glm::ivec2 size, Pipeline::OnError on_error, OnReady on_ready = {});

  const Manifest& manifest() const { return source_->manifest(); }
  const Timeline& timeline() const { return clock_.timeline(); }

  const std::string& name() const override { return manifest().name; }
  Up up() const override { return manifest().up; }
  double frame_seconds() const override;
  Box bounds() const override { return manifest().bounds; }
  std::vector<ScalarRange> scalars() const override { return manifest().scalars; }
  void look(const Camera& camera, glm::ivec2 size) override;
  void set_prepare_options(const PrepareOptions& options) override;
  PrepareOptions prepare_options() const;
  Update update(Clock::TimePoint now) override;
  std::optional<std::string> trouble() const override { return source_->trouble(); }
  std::uint64_t dropped() const override { return dropped_; }
  std::uint64_t errors() const override { return pipeline_->errors(); }

  /// The layers that the current mode draws of frames down to this level.
  LayerRange choice(int level) const;

  // Time. It stands still, as if paused, until the first frame is there, and whenever the link does
  // not bring frames in time. Frames that the machine does not make in time are dropped.

  void play(Clock::TimePoint now);
  void pause(Clock::TimePoint now);
  void toggle_play(Clock::TimePoint now) { playing() ? pause(now) : play(now); }
  void seek(std::uint64_t time_us, Clock::TimePoint now);
  void seek_by(std::int64_t delta_us, Clock::TimePoint now);
  /// Pauses, and goes that many frames forward, or back if negative.
  void step(std::int64_t frames, Clock::TimePoint now);
  /// Clock::set_speed.
  void set_speed(double speed, Clock::TimePoint now);
  void set_loop(bool loop, Clock::TimePoint now);
  void toggle_loop(Clock::TimePoint now) { set_loop(!clock_.loop(), now); }
  /// Clock::set_loop_range. Playback goes on at the range's beginning without a gap.
  void set_loop_range(const std::optional<LoopRange>& range, Clock::TimePoint now);
  const std::optional<LoopRange>& loop_range() const { return clock_.loop_range(); }
  bool playing() const {
    return scrubbing_ ? played_before_scrub_ : started_ ? clock_.playing() : begins_;
  }
  double speed() const { return clock_.speed(); }
  bool loop() const { return clock_.loop(); }
  std::uint64_t position_us(Clock::TimePoint now) const {
    return clock_.read(paced(now)).position_us;
  }
  /// Clock::without_frames of its clock, which reads the times of Options::time.
  Clock position() const { return clock_.without_frames(); }

  /// Source::fetch_audio. May be called from any thread.
  Result<Bytes> fetch_audio(std::uint64_t offset, std::uint64_t size,
                            const std::stop_token& stop) const {
    return source_->fetch_audio(offset, size, stop);
  }

  // While a timeline is dragged, coarse pictures of exactly the frame under the cursor are shown.
  // At the end of the drag the frame is refined, and playback goes on if it was playing.

  void scrub_begin(Clock::TimePoint now);
  void scrub_to(std::uint64_t time_us, Clock::TimePoint now);
  void scrub_end(Clock::TimePoint now);
  bool scrubbing() const { return scrubbing_; }
  /// Whether it stands still although it plays, until frames come.
  bool waiting() const { return clock_.held(); }

  // Without a clock: frames in any order, each as soon as it is there.

  /// Goes to `frame` and waits, no longer than `timeout`, until it has all levels that are seen.
  FrameBuffer::State await(std::uint32_t frame, std::chrono::milliseconds timeout);
  std::shared_ptr<const SceneFrame> best() const { return buffer_.best(); }

  /// FrameBuffer::buffered.
  std::vector<BufferedRange> buffered() const { return buffer_.buffered(); }

  /// Thumbnails::get. Does not disturb playback.
  std::shared_ptr<const SceneFrame> thumbnail(std::uint32_t frame);

  // What was chosen, and how it went.

  /// LayerPlan::chosen.
  std::vector<LayerPlan::Chosen> chosen() const { return plan_.chosen(); }
  /// What is fetched next, and why not more.
  LayerDecision decision() const { return plan_.decide(seen_options()); }

  struct Statistics {
    std::uint64_t fetched_bytes = 0;
    std::uint64_t refetched = 0;      ///< layers that came damaged
    std::uint64_t reused = 0;         ///< frames that were shown again without being made again
    double link_bits_per_second = 0;  ///< 0: not known
    double buffered_seconds = 0;      ///< how long the frames fetched so far will last
    /// How often playback stood still for want of frames, other than at its start and after jumps.
    std::uint64_t stalls = 0;
    double stalled_seconds = 0, longest_stall_seconds = 0;
    // Memory.
    std::uint64_t stored_bytes = 0;  ///< taken by coded frames
    std::uint64_t frame_bytes = 0;   ///< taken by frames that are ready, and by thumbnails
  };
  Statistics statistics() const;

 private:
  Clock::TimePoint paced(Clock::TimePoint now) const {
    return options_.time ? options_.time->at(now) : now;
  }
  Result<SceneFrame> prepare(const FrameRequest& request, const FetchedFrame& fetched);
  PrepareOptions seen_options() const;
  void set_level();
  void set_pace();
  void release(Clock::TimePoint now);
  void hold_if_starved(Clock::TimePoint now);
  void update_plan(Clock::TimePoint now);
  void jump(Clock::TimePoint now, int direction);
  std::optional<Clock::TimePoint> due(Clock::TimePoint now) const;
  void count_dropped(const SceneFrame& frame, const Clock::Reading& reading);

  const std::unique_ptr<Source> source_;
  const Options options_;
  const OnReady on_ready_;
  Clock clock_;
  bool started_ = false;  ///< the first frame came, or failed
  bool begins_ = true;    ///< it plays from then on
  LayerPlan plan_;
  FrameBuffer buffer_;
  /// Guards prepare_, strip_record_, and what voxel_depth_ learns by its delta.
  mutable std::mutex prepare_mutex_;
  PrepareOptions prepare_;
  std::shared_ptr<const StripRecord> strip_record_;  ///< of some frame in strip mode, or null
  std::uint32_t playhead_ = 0;
  // The camera and the size that view_level_ was found for.
  std::optional<Camera> camera_;
  glm::ivec2 size_{0};
  std::atomic<int> view_level_{kWholeFrame};  ///< the finest level that the camera shows
  VoxelDepth voxel_depth_;
  std::mutex level_mutex_;  ///< held while the buffer is told which level is seen
  std::shared_ptr<const SceneFrame> given_;
  std::optional<std::int64_t> given_ordinal_;  ///< none after a jump
  std::uint64_t dropped_ = 0;
  bool awaiting_ = false;  ///< await() has been called: time does not matter
  bool scrubbing_ = false, played_before_scrub_ = false;
  // Standing still.
  enum class Hold { none, jump, starved } hold_ = Hold::none;
  Clock::TimePoint held_since_{};
  Statistics statistics_;
  FrameBuffer::Fill fill_;  ///< as of the last update
  // These come last because their threads use everything above.
  std::optional<Pipeline> pipeline_;
  std::optional<Thumbnails> thumbnails_;
};

}  // namespace pointreel
