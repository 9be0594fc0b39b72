#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "client/playback/clock.h"
#include "client/sound/audio_samples.h"
#include "codec/live/live_sound.h"

struct OpusDecoder;

namespace pointreel {

/// The sound of a live stream: decoded packets of the last few seconds, at their times of capture,
/// and the clock by which they are played. Any thread may call anything.
///
/// Sound is played with the delay of the picture, or later where it comes later than that. When
/// this changes, it jumps, so that small changes are left alone.
///
/// Trust: packets may be hostile. What cannot be decoded is silence, and memory does not grow.
/// Samples are finite.
class LiveTrack : public AudioSamples {
 public:
  LiveTrack();
  ~LiveTrack() override;

  /// A packet that came at `now_us`, Unix time.
  void add(const LiveSound& sound, std::uint64_t now_us);
  bool copy(std::int64_t first, std::span<StereoSample> to) override;
  void want(const std::vector<std::int64_t>&) override {}

  /// What is to be heard now; none before the first packet. `now`: as for Clock, for the sound that
  /// is heard at `now_us`. `picture_delay_us`: from capture to picture, if known.
  std::optional<Clock> clock(Clock::TimePoint now, std::uint64_t now_us,
                             std::optional<std::int64_t> picture_delay_us);
  bool begun() const;
  /// From capture to ear.
  std::int64_t delay_us() const;
  /// How often what was copied had not come in full.
  std::uint64_t gaps() const;

 private:
  void place(std::int64_t first, std::span<const StereoSample> samples);
  void restart(std::uint64_t capture_us);

  struct Decoder {
    void operator()(OpusDecoder* decoder) const;
  };
  const std::unique_ptr<OpusDecoder, Decoder> decoder_;
  mutable std::mutex mutex_;  ///< guards what follows
  std::vector<StereoSample> decoded_, ring_;
  std::optional<std::uint32_t> number_;  ///< of the last packet
  std::uint64_t origin_us_ = 0;          ///< the time of sample 0; 0 before the first packet
  std::int64_t end_ = 0;                 ///< behind the newest sample
  std::int64_t needed_us_ = 0;           ///< the delay with which all packets come in time
  std::int64_t delay_us_ = 0;
  std::uint64_t gaps_ = 0;
  std::optional<Clock> clock_;
  Clock::TimePoint set_{};  ///< when the clock was set
};

}  // namespace pointreel
