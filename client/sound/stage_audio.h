#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "client/playback/paced_time.h"
#include "client/playback/stage.h"
#include "client/sound/audio_player.h"
#include "client/sound/live_track.h"

namespace pointreel {

/// Plays the sound of the reels and live streams on a stage, on threads of its own. Where no device
/// can be opened, there is silence, and playback goes by the machine's time.
class StageAudio {
 public:
  /// Called by any thread if the sound of a reel cannot be played; `source` is its index.
  using OnError = std::function<void(std::size_t source, const Error&)>;

  /// `device`: as for open_audio_device; none: reels are silent.
  StageAudio(std::optional<std::string> device, OnError on_error);
  ~StageAudio();
  StageAudio(const StageAudio&) = delete;
  StageAudio& operator=(const StageAudio&) = delete;

  /// For ReelPlayback::Options of the stages that are played.
  const std::shared_ptr<PacedTime>& time() const { return time_; }

  /// Plays what is on this stage, which must live until the next call; null: nothing.
  void begin(Stage* stage);
  /// To be called whenever the time of reels may have been changed, by the user or by update().
  /// `volume`: as for AudioPlayer::set_volume.
  void follow(double volume);

  /// None if nothing on the stage has sound, or a live stream has sent none yet.
  std::optional<AudioPlayer::Statistics> statistics() const;

 private:
  void start();

  const std::optional<std::string> device_;
  const OnError on_error_;
  const std::shared_ptr<PacedTime> time_ = std::make_shared<PacedTime>();
  Stage* stage_ = nullptr;
  std::vector<std::shared_ptr<AudioSamples>> sounds_;  ///< by source; null: silent
  std::vector<std::shared_ptr<LiveTrack>> live_;       ///< by source; null: a reel
  std::unique_ptr<AudioPlayer> player_;                ///< null if nothing has sound
  std::jthread thread_;                                ///< last, because it uses the player
};

}  // namespace pointreel
