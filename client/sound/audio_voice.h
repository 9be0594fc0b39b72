#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "client/playback/clock.h"
#include "client/sound/audio_samples.h"

namespace pointreel {

/// Makes what is heard of a reel, from what its clock says: at any time, the sound of the position
/// at that time, and silence while playback stands still or goes backward. Speed does not change
/// the pitch.
///
/// Sound is made of grains, two hops long, that overlap by half and fade into one another (overlap
/// and add). Playing at normal speed, each grain follows on the one before, and the samples come
/// out as they are. At another speed, a grain is taken from where it fits best to the one before,
/// no farther than kReach from its position (WSOLA: Verhelst, Roelands, "An overlap-add technique
/// based on waveform similarity", ICASSP 1993). Jumps, pauses and loops fade within a hop.
class AudioVoice {
 public:
  static constexpr std::size_t kHop = kAudioRate / 100;
  static constexpr std::int64_t kReach = kHop;

  /// The samples must outlive it.
  explicit AudioVoice(AudioSamples& samples) : samples_(samples) {}

  /// Adds the next kHop samples to `to`. They are heard from `begin` on, a time of the clock; calls
  /// follow one another by kHop.
  void add_hop(const Clock& clock, Clock::TimePoint begin, std::span<StereoSample, kHop> to);

  /// The first sample of the last hop's grain, whose middle is where the clock says; none if it is
  /// silent.
  std::optional<std::int64_t> position() const { return position_; }
  /// Whether the last hop went on from the one before, without a jump.
  bool steady() const { return steady_; }

 private:
  using Grain = std::array<StereoSample, 2 * kHop>;

  void want(const Clock& clock, Clock::TimePoint begin);
  std::int64_t best_fit(std::int64_t nominal, std::int64_t natural, std::int64_t reach);

  AudioSamples& samples_;
  Grain grain_{};                         ///< the last one; silence to begin with
  std::optional<std::int64_t> position_;  ///< of the last grain
  std::optional<std::int64_t> nominal_;   ///< what the clock said for it
  bool steady_ = false;
};

}  // namespace pointreel
