#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <optional>

#include "client/source/live_frames.h"
#include "codec/live/live.h"

namespace pointreel {

/// LiveFrames between the thread that receives layers and the thread that wants the newest frame.
/// `hello`, `next` and `counts` are those of LiveSource.
///
/// Trust: layers may be hostile (live_frames.h).
class LiveAssembler {
 public:
  using Clock = std::chrono::steady_clock;

  explicit LiveAssembler(Clock::duration patience = std::chrono::milliseconds(15))
      : frames_(patience) {}

  // For the receiving thread: as those of LiveFrames.

  void add(LiveHello hello);
  void add(const LiveLayer& layer, SharedBytes bytes);
  void add_bad();
  void set_dropped(std::uint64_t layers);
  void reconnected();

  // For any thread.

  std::optional<LiveHello> hello(std::chrono::milliseconds timeout);
  std::optional<LiveFrame> next(std::chrono::milliseconds timeout);
  LiveCounts counts() const;
  void cancel();

 private:
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  bool cancelled_ = false;
  LiveFrames frames_;
};

}  // namespace pointreel
