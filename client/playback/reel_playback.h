#pragma once

#include <atomic>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include <glm/glm.hpp>

#include "client/playback/buffer.h"
#include "client/playback/clock.h"
#include "client/playback/layer_control.h"
#include "client/playback/pipeline.h"
#include "client/playback/playback.h"
#include "client/playback/thumbnails.h"
#include "client/prepare/layer_choice.h"
#include "client/prepare/prepare.h"
#include "client/scene/camera.h"
#include "client/scene/frame.h"
#include "client/source/source.h"

namespace pointreel {

/// Everything that plays one reel: where its frames come from, what time it is, what is fetched and
/// decoded for the view, and the frames that are ready.
class ReelPlayback : public Playback {
 public:
  struct Options {
    PrepareOptions prepare;
    bool loop = true;
    double speed = 1.0;
    std::uint64_t start_us = 0;
    bool remote = false;  ///< round trips take time: more frames are fetched at once, and ahead
    bool single_frame = false;  ///< only the first one will be asked for
    /// Of a remote reel's coded frames that are kept, besides those that are played next.
    std::uint64_t store_bytes = std::uint64_t{96} << 20;
  };

  /// Begins to fetch what the camera shows in a picture of `size` pixels. The source has at least
  /// one frame. `on_error`: Pipeline::OnError.
  ReelPlayback(std::unique_ptr<Source> source, const Options& options, const Camera& camera,
               glm::ivec2 size, Pipeline::OnError on_error, OnReady on_ready = {});

  const Manifest& manifest() const { return source_->manifest(); }
  const Timeline& timeline() const { return clock_.timeline(); }

  const std::string& name() const override { return manifest().name; }
  char up() const override { return manifest().up; }
  double frame_seconds() const override;
  Box bounds() const override { return manifest().bounds; }
  void look(const Camera& camera, glm::ivec2 size) override;
  void set_prepare_options(const PrepareOptions& options) override;
  PrepareOptions prepare_options() const;
  Update update(Clock::TimePoint now) override;
  std::optional<std::string> trouble() const override { return source_->trouble(); }
  std::uint64_t dropped() const override { return dropped_; }
  std::uint64_t errors() const override { return pipeline_->errors(); }

  /// The layers of frames with this level that the current mode draws.
  LayerRange choice(int level) const;

  // Time. Stands still, as if paused, until the first frame is there, and wherever the link does
  // not bring frames in time: what the machine does not make in time is dropped.

  void play(Clock::TimePoint now);
  void pause(Clock::TimePoint now);
  void toggle_play(Clock::TimePoint now) { playing() ? pause(now) : play(now); }
  void seek(std::uint64_t time_us, Clock::TimePoint now);
  void seek_by(std::int64_t delta_us, Clock::TimePoint now);
  /// Pauses, and goes so many frames on or back.
  void step(std::int64_t frames, Clock::TimePoint now);
  /// Negative: backward. Clamped as the clock says.
  void set_speed(double speed, Clock::TimePoint now);
  void set_loop(bool loop, Clock::TimePoint now);
  void toggle_loop(Clock::TimePoint now) { set_loop(!clock_.loop(), now); }
  /// Clock::set_loop_range: between two times, again and again, without a gap.
  void set_loop_range(const std::optional<LoopRange>& range, Clock::TimePoint now);
  const std::optional<LoopRange>& loop_range() const { return clock_.loop_range(); }
  bool playing() const {
    return scrubbing_ ? played_before_scrub_ : started_ ? clock_.playing() : begins_;
  }
  double speed() const { return clock_.speed(); }
  bool loop() const { return clock_.loop(); }
  std::uint64_t position_us(Clock::TimePoint now) const { return clock_.read(now).position_us; }

  // While a timeline is dragged: coarse pictures of exactly the frame under the cursor; at the end
  // it is refined, and playback goes on if it was playing.

  void scrub_begin(Clock::TimePoint now);
  void scrub_to(std::uint64_t time_us, Clock::TimePoint now);
  void scrub_end(Clock::TimePoint now);
  bool scrubbing() const { return scrubbing_; }
  /// Stands still, though it plays, until frames come.
  bool waiting() const { return clock_.held(); }

  // Without a clock: frames in any order, each as soon as it is there.

  /// Goes to `frame` and waits for it, with all the levels that are seen, at most for `timeout`.
  FrameBuffer::State await(std::uint32_t frame, std::chrono::milliseconds timeout);
  std::shared_ptr<const SceneFrame> best() const { return buffer_.best(); }

  /// Which frames are there, and with how many layers, in order.
  std::vector<BufferedRange> buffered() const { return buffer_.buffered(); }

  /// A coarse picture of any frame, as Thumbnails::get gives it: null until it is there. Does not
  /// disturb playback.
  std::shared_ptr<const SceneFrame> thumbnail(std::uint32_t frame);

  // What was chosen, and how it went.

  /// Of the frames from here to the next entry's, or the end of what was fetched so far.
  struct Chosen {
    std::uint32_t first_frame = 0;  ///< of a segment
    LayerDecision decision;
  };
  /// The last choice for each segment, those that follow each other and are alike in one.
  std::vector<Chosen> chosen() const;
  /// What is fetched next, and why no more.
  LayerDecision decision() const;

  struct Statistics {
    std::uint64_t fetched_bytes = 0;
    std::uint64_t refetched = 0;      ///< layers that came damaged
    double link_bits_per_second = 0;  ///< 0: not known
    double buffered_seconds = 0;      ///< that could be played from what has been fetched
    /// Times at which playback stood still for want of frames, but for its start and after jumps.
    std::uint64_t stalls = 0;
    double stalled_seconds = 0, longest_stall_seconds = 0;
    // What is held.
    std::uint64_t stored_bytes = 0;  ///< of coded frames
    std::uint64_t frame_bytes = 0;   ///< of frames that are ready, thumbnails included
  };
  Statistics statistics() const;

 private:
  Result<SceneFrame> prepare(const FrameRequest& request, const FetchedFrame& fetched);
  LayerDecision wanted(DrawMode mode, int level) const;
  LayerCaps caps() const;
  int seen_level() const;
  void set_level();
  void set_pace();
  void release(Clock::TimePoint now);
  void hold_if_starved(Clock::TimePoint now);
  void control(Clock::TimePoint now);
  void set_caps(const LayerCaps& caps);
  void note_choice(std::uint32_t frame);
  void jump(Clock::TimePoint now, int direction);
  std::optional<Clock::TimePoint> due(Clock::TimePoint now) const;
  void count_dropped(const SceneFrame& frame, const Clock::Reading& reading);

  const std::unique_ptr<Source> source_;
  const Options options_;
  const OnReady on_ready_;
  Clock clock_;
  bool started_ = false;  ///< the first frame came, or failed
  bool begins_ = true;    ///< it plays from then on
  FrameBuffer buffer_;
  mutable std::mutex prepare_mutex_;
  PrepareOptions prepare_;
  std::uint32_t playhead_ = 0;
  std::optional<Camera> camera_;  ///< what view_level_ was found for
  glm::ivec2 size_{0};
  std::atomic<int> view_level_{kWholeFrame};  ///< the finest level that the camera can show
  VoxelDepth voxel_depth_;
  std::mutex level_mutex_;  ///< of telling the buffer what of both is seen
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
  // What is fetched.
  mutable std::mutex control_mutex_;
  LayerControl control_;
  std::atomic<Rung> link_cap_{LayerCaps{}.link};
  std::atomic<std::uint32_t> machine_cap_{LayerCaps{}.machine_layers};
  std::optional<Clock::TimePoint> first_control_;
  LinkUse link_use_;                               ///< as of the last update
  std::map<std::uint32_t, LayerDecision> chosen_;  ///< by segment
  // Last: their threads use what is above.
  std::optional<Pipeline> pipeline_;
  std::optional<Thumbnails> thumbnails_;
};

}  // namespace pointreel
