#pragma once

#include <chrono>
#include <cstddef>
#include <span>

#include "codec/audio/opus_reader.h"
#include "pointreel/error.h"

namespace pointreel {

/// Something that plays samples at its own pace, which is kAudioRate only nearly. One thread makes
/// all calls.
class AudioDevice {
 public:
  using TimePoint = std::chrono::steady_clock::time_point;

  struct State {
    std::size_t room = 0;  ///< how many samples can be written now
    /// How many samples are heard, from `now` on, until one is that is written now: those that are
    /// waiting, and what the way to the ear takes.
    double delay = 0.0;
    bool broken_off = false;  ///< since the last call, nothing was heard for a while
  };

  virtual ~AudioDevice() = default;

  /// `now` must not decrease. An error is final.
  virtual Result<State> state(TimePoint now) = 0;
  /// No more samples than there is room for, by the last call of state().
  virtual Result<void> write(std::span<const StereoSample> samples) = 0;
};

}  // namespace pointreel
