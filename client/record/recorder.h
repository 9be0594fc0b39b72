#pragma once

#include <cstdint>

#include "client/render/image.h"
#include "pointreel/error.h"

namespace pointreel {

/// Writes the pictures of a recording.
class Recorder {
 public:
  virtual ~Recorder() = default;

  /// Adds the next picture, which is shown from `time_us` on. Times increase, and all pictures have
  /// the same size.
  virtual Result<void> add(const Image& picture, std::uint64_t time_us) = 0;
  /// Completes the recording after the last picture, which is shown until `end_us`. Without it,
  /// there may be no recording.
  virtual Result<void> finish(std::uint64_t end_us) = 0;
};

}  // namespace pointreel
