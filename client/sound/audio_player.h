#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "client/playback/clock.h"
#include "client/playback/paced_time.h"
#include "client/sound/audio_device.h"
#include "client/sound/audio_samples.h"
#include "client/sound/audio_voice.h"

namespace pointreel {

/// Plays the sound of reels on a device, together with their pictures.
///
/// The device's clock leads: it counts the samples that have been heard, paced time follows it, and
/// reels are played by paced time. The sound of each moment is that of the position which a reel's
/// clock has at that moment, whatever was done to the clock. For this reason the two cannot drift
/// apart, and after any jump they are together again at once. What has been handed to the device
/// cannot be taken back: a jump is heard when the device's delay has passed.
///
/// One thread calls pump(), the others may be called from any thread.
class AudioPlayer {
 public:
  using TimePoint = Clock::TimePoint;

  using OpenDevice = std::function<Result<std::unique_ptr<AudioDevice>>()>;

  /// The first pump() opens the device, which may take a while. `time` is the time by which the
  /// reels play.
  AudioPlayer(OpenDevice open, std::shared_ptr<PacedTime> time);

  /// Plays these from now on, once follow() has told their clocks; null for reels that are silent.
  void begin(const std::vector<std::shared_ptr<AudioSamples>>& sounds);
  /// What the clock of a sound says from now on (ReelPlayback::position), by its index.
  void follow(std::size_t sound, const Clock& clock);
  /// Loudness from 0 to 1, as heard: half of it sounds half as loud.
  void set_volume(double volume);

  /// Gives the device samples, if it has room for some. To be called every kPeriod or more often,
  /// with the machine's time. False after an error of the device, which is final: paced time is
  /// then the machine's.
  static constexpr std::chrono::milliseconds kPeriod{8};
  bool pump(TimePoint now);

  struct Statistics {
    bool plays = false;        ///< the device works
    std::string error;         ///< why it does not, or does no longer
    double delay_ms = 0.0;     ///< of the device, as of the last pump
    std::uint64_t breaks = 0;  ///< how often the device had nothing to play
    /// How far what is heard is ahead of the clock, measured at each pump while a reel plays
    /// without a jump: the mean, and the one farthest from 0.
    double mean_offset_ms = 0.0, worst_offset_ms = 0.0;
    std::uint64_t offsets = 0;  ///< how many were measured
    /// When the first sound was handed to the device, with its delay added.
    std::optional<TimePoint> first_heard;
    /// Of the first live stream with sound: from capture to ear, and how many hops of 10 ms had not
    /// come when they were handed to the device.
    std::optional<double> capture_to_sound_ms;
    std::uint64_t gaps = 0;
  };
  Statistics statistics() const;

 private:
  struct Sound {
    std::shared_ptr<AudioSamples> samples;
    AudioVoice voice;
    std::optional<Clock> clock;
  };
  /// What was handed to the device, for as long as it is not heard.
  struct Handed {
    std::uint64_t first = 0;               ///< number of the hop's first sample
    std::optional<std::int64_t> position;  ///< in the first sound that is not silent
    bool steady = false;
  };

  TimePoint time_of(std::uint64_t sample) const;
  void pace(const AudioDevice::State& state, TimePoint now);
  void measure(double heard, TimePoint now);
  Result<void> play(TimePoint now);
  Result<void> fill(std::size_t room, TimePoint now);
  void mix(TimePoint now);

  OpenDevice open_;  ///< until it has been called
  std::unique_ptr<AudioDevice> device_;
  const std::shared_ptr<PacedTime> time_;
  mutable std::mutex mutex_;  ///< guards what follows
  std::vector<std::unique_ptr<Sound>> sounds_;
  float gain_ = 1.0f, gain_before_ = 1.0f;
  std::array<StereoSample, AudioVoice::kHop> mixed_{};
  std::span<const StereoSample> rest_;  ///< of these, what the device had no room for
  std::uint64_t written_ = 0;           ///< samples
  std::optional<TimePoint> first_;      ///< the paced time of sample 0
  double mean_off_ = 0.0;               ///< seconds that the device is ahead of paced time
  std::deque<Handed> handed_;
  Statistics statistics_;
  double sum_of_offsets_ms_ = 0.0;
};

}  // namespace pointreel
