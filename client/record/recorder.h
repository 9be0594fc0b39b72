#pragma once

#include <cstdint>

#include "client/render/image.h"
#include "pointreel/error.h"

namespace pointreel {

/// Where the pictures of a recording go.
class Recorder {
 public:
  virtual ~Recorder() = default;

  /// The next picture, seen from `time_us` on, which is after that of the one before. All pictures
  /// have the same size.
  virtual Result<void> add(const Image& picture, std::uint64_t time_us) = 0;
  /// All pictures have been added. A recording that was not finished may be missing.
  virtual Result<void> finish() = 0;
};

}  // namespace pointreel
