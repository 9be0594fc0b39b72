#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "codec/files/cloud_format.h"
#include "pointreel/bytes.h"
#include "pointreel/error.h"

namespace pointreel {

/// What a recording lacks.
struct RecordingLoss {
  std::vector<std::string> warnings;  ///< lines without the recording's name
  std::size_t parts = 0;              ///< damaged parts that were left out
};

/// Many clouds in one file or folder, in order. Frames are read when they are asked for, and may be
/// asked for by several threads at once.
class Recording {
 public:
  virtual ~Recording() = default;

  /// Of what `read` returns.
  virtual CloudFormat format() const = 0;
  virtual std::size_t size() const = 0;  ///< the number of frames, at least 1
  /// Nanoseconds since 1970, or since some time that the recording does not tell.
  virtual std::optional<std::uint64_t> time_ns(std::size_t frame) const = 0;
  virtual RecordingLoss loss() const { return {}; }
  /// What it does not tell and was assumed of it, for people.
  virtual std::vector<std::string> guesses() const { return {}; }
  /// What the frame is called within the recording, for errors: "message 3".
  virtual std::string name(std::size_t frame) const = 0;
  /// The error does not contain the name.
  virtual Result<Bytes> read(std::size_t frame) const = 0;
};

}  // namespace pointreel
