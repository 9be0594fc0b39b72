#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "codec/cloud_file.h"
#include "pointreel/error.h"

/// Where a publisher's frames come from. Whoever is too slow for them gets the newest, and those
/// between are skipped.
namespace pointreel {

/// Unix time in microseconds, and waiting for it; tests give their own.
struct LiveClock {
  std::function<std::uint64_t()> now_us;
  /// Returns at that time, or soon after the stop.
  std::function<void(std::uint64_t time_us, const std::stop_token& stop)> wait_until;

  static LiveClock system();
};

struct InputFrame {
  std::string name;              ///< for errors
  std::uint64_t capture_us = 0;  ///< Unix time
  Result<LoadedCloud> cloud;     ///< the error does not repeat the name
};

class FrameInput {
 public:
  virtual ~FrameInput() = default;
  /// Waits for the next frame. Nothing: there are no more, or it was stopped. An error ends the
  /// input.
  virtual Result<std::optional<InputFrame>> next(const std::stop_token& stop) = 0;
  /// Frames that were not taken in time.
  virtual std::uint64_t skipped() const = 0;
};

/// The files one after another, so many a second from the first `next` on, read ahead of their
/// time. `loop`: again and again.
std::unique_ptr<FrameInput> play_files(std::vector<std::filesystem::path> files, double fps,
                                       bool loop, LiveClock clock = LiveClock::system());

/// The newest .ply or .drc file that is in the folder, if one is; then each that is put there,
/// by closing or renaming it, when that happens.
Result<std::unique_ptr<FrameInput>> follow_folder(const std::filesystem::path& folder,
                                                  LiveClock clock = LiveClock::system());

/// From a pipe: for each frame four bytes, the little-endian size, then a PLY or Draco file of that
/// size. It is captured when its last byte is read. The descriptor is not closed.
///
/// Trust: memory is taken for bytes that have come, up to kMaxInputFrame.
std::unique_ptr<FrameInput> read_pipe(int descriptor, LiveClock clock = LiveClock::system());

inline constexpr std::uint32_t kMaxInputFrame = 1u << 30;

}  // namespace pointreel
