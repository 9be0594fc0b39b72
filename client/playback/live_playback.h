#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "client/playback/playback.h"
#include "client/prepare/prepare.h"
#include "client/source/live_source.h"
#include "codec/live/live.h"
#include "pointreel/error.h"

namespace pointreel {

/// Plays a live stream: always the newest frame that is ready. Threads take the newest frame that
/// no other thread works on, so that a slow machine shows fewer frames, but none of them later.
///
/// SceneFrame::index is the frame's number, and time_us the Unix time of its capture, by the
/// publisher's clock.
class LivePlayback : public Playback {
 public:
  struct Options {
    PrepareOptions prepare;
    unsigned prepare_threads = 2;  ///< >= 1
  };
  /// Called for each frame that could not be prepared, by the thread that tried.
  using OnError = std::function<void(std::uint32_t frame, const Error&)>;

  /// `name`: to show to the user.
  LivePlayback(std::unique_ptr<LiveSource> source, std::string name, const Options& options,
               OnError on_error, OnReady on_ready = {});
  /// Cancels the source and waits for the threads.
  ~LivePlayback() override;

  const std::string& name() const override { return name_; }
  Up up() const override;
  double frame_seconds() const override;
  Box bounds() const override;
  std::vector<ScalarRange> scalars() const override;
  void look(const Camera& camera, glm::ivec2 size) override;
  /// Counts for frames that come from now on.
  void set_prepare_options(const PrepareOptions& options) override;
  Update update(Clock::TimePoint now) override;
  std::optional<std::string> trouble() const override { return source_->trouble(); }
  /// Frames that came but were never shown, because a newer one was ready or begun before them.
  std::uint64_t dropped() const override;
  std::uint64_t errors() const override { return errors_; }

  /// As LiveSource::set_on_sound.
  void set_on_sound(LiveSource::OnSound on_sound) { source_->set_on_sound(std::move(on_sound)); }
  /// From capture to picture, in the mean of the last pictures; none before the first.
  std::optional<std::int64_t> delay_us() const;

  LiveCounts counts() const { return source_->counts(); }
  /// As LiveSource::refusal. update() says that playing has ended then.
  std::optional<Error> refusal() const { return source_->refusal(); }

  /// Stands still, once there is a picture. Frames that come meanwhile are left out.
  void pause() { playing_ = false; }
  /// Goes on with the newest frame.
  void play() { playing_ = true; }
  bool playing() const { return playing_; }

 private:
  // One template for both structs makes clang 19 crash.
  /// A frame that came.
  struct Received {
    std::uint64_t order = 0;  ///< rises with each frame, whatever the publisher's numbers do
    LiveFrame frame;
  };
  /// A frame that is prepared.
  struct Ready {
    std::uint64_t order = 0;  ///< of the frame that came
    std::shared_ptr<const SceneFrame> frame;
  };

  void end();
  void receive();
  void prepare();
  Result<SceneFrame> prepare(LiveFrame& frame);
  void deliver(std::uint64_t order, std::shared_ptr<const SceneFrame> frame);
  void find_level();

  const std::unique_ptr<LiveSource> source_;
  const OnError on_error_;
  const OnReady on_ready_;
  const std::string name_;
  std::atomic<bool> playing_{true};
  std::atomic<std::uint64_t> errors_{0};

  mutable std::mutex mutex_;  ///< guards what follows, up to the threads
  std::condition_variable changed_;
  bool ending_ = false;
  LiveHello stream_;  ///< what the publisher says; the defaults until then
  PrepareOptions prepare_;
  std::shared_ptr<const StripRecord> strip_record_;  ///< of some frame in strip mode, or null
  std::optional<Received> received_;                 ///< the newest that no thread works on yet
  Ready ready_;                                      ///< the newest; null at first
  Ready given_;                                      ///< what the last update gave
  std::optional<std::int64_t> delay_us_;
  std::uint64_t overtaken_ = 0;
  std::optional<Camera> camera_;
  glm::ivec2 size_{0};
  int level_ = kWholeFrame;  ///< the finest that the camera shows

  std::jthread receiver_;
  std::vector<std::jthread> preparers_;
};

}  // namespace pointreel
