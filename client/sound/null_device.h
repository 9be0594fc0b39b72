#pragma once

#include <cstdint>
#include <optional>

#include "client/sound/audio_device.h"

namespace pointreel {

/// A device that nobody hears, for tests and measurements.
class NullDevice : public AudioDevice {
 public:
  /// `pace`: how many times as fast as kAudioRate it plays. `latency`: samples that are on their
  /// way to the ear, in addition to those that wait.
  explicit NullDevice(double pace = 1.0, std::size_t latency = 0)
      : pace_(pace), latency_(latency) {}

  Result<State> state(TimePoint now) override;
  Result<void> write(std::span<const StereoSample> samples) override;

 private:
  static constexpr std::size_t kBuffer = kAudioRate / 20;

  const double pace_;
  const std::size_t latency_;
  std::optional<TimePoint> last_;
  double waiting_ = 0.0;  ///< samples, as of `last_`
};

}  // namespace pointreel
