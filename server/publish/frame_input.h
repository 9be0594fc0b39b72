#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "codec/files/cloud_file.h"
#include "pointreel/error.h"

/// Where the frames of a publisher come from. A publisher that takes frames too slowly gets the
/// newest one; those in between are skipped.
namespace pointreel {

/// The time, and waiting for it. Tests have clocks of their own.
struct LiveClock {
  std::function<std::uint64_t()> now_us;  ///< as unix_time_us()
  /// Returns at that time, or soon after `stop` was requested.
  std::function<void(std::uint64_t time_us, const std::stop_token& stop)> wait_until;

  static LiveClock system();
};

struct InputFrame {
  std::string name;              ///< the file, or the number of the frame, for error messages
  std::uint64_t capture_us = 0;  ///< by the LiveClock
  Result<LoadedCloud> cloud;     ///< the error begins with `name`
};

class FrameInput {
 public:
  virtual ~FrameInput() = default;
  /// Waits for the next frame; nothing if there are no more or `stop` was requested. After an error
  /// there are no more frames.
  virtual Result<std::optional<InputFrame>> next(const std::stop_token& stop) = 0;
  /// The number of frames that were not taken in time.
  virtual std::uint64_t skipped() const = 0;
};

/// Plays the frames one after another from the first call of `next` on, at their own times, or at
/// `fps` if they have none, and reads them ahead of time. With `loop` it begins again at the end.
/// `max_memory`: DecodeLimits::max_memory of a frame, here and below.
std::unique_ptr<FrameInput> play_files(CloudSequence sequence, double fps, bool loop,
                                       LiveClock clock = LiveClock::system(),
                                       std::uint64_t max_memory = kFrameMemory);

/// The newest file of points in the folder, if there is one, and then each file that is added by
/// closing, renaming or linking it. All are read like the first (`asked`: what is not to be guessed
/// of that). Ends with an error if the folder itself is removed or renamed.
Result<std::unique_ptr<FrameInput>> follow_folder(const std::filesystem::path& folder,
                                                  LiveClock clock = LiveClock::system(),
                                                  Reading asked = {},
                                                  std::uint64_t max_memory = kFrameMemory);

/// Reads a pipe. Each frame is its size in four bytes, little endian, and then a file of that
/// size, of a format that is recognised by its first bytes. Its time of capture is when its last
/// byte was read. All are read like the first. The descriptor is not closed.
///
/// Trust: memory grows only with the bytes that have arrived, up to kMaxInputFrame.
std::unique_ptr<FrameInput> read_pipe(int descriptor, LiveClock clock = LiveClock::system(),
                                      Reading asked = {}, std::uint64_t max_memory = kFrameMemory);

inline constexpr std::uint32_t kMaxInputFrame = 1u << 30;

}  // namespace pointreel
