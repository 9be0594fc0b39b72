#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "codec/audio/opus_reader.h"

namespace pointreel {

/// The sound of a reel, at kAudioRate, as far as it has come.
class AudioSamples {
 public:
  virtual ~AudioSamples() = default;

  /// Copies the samples from number `first` on, which may be negative. Where there are none, or
  /// they have not come yet, is silence. Returns soon. False if any have not come.
  virtual bool copy(std::int64_t first, std::span<StereoSample> to) = 0;
  /// What will be copied soon, in this order: numbers of samples, not far apart in each run of
  /// play. Replaces what was wanted before.
  virtual void want(const std::vector<std::int64_t>& samples) = 0;
};

}  // namespace pointreel
