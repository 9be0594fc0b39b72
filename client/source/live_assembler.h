#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <optional>

#include "client/source/live_source.h"
#include "common/stream/live.h"

namespace pointreel {

/// Assembles the layers of a live stream into frames, between the thread that receives them and the
/// thread that wants the newest frame. It holds no more than two frames: one that is coming and one
/// that has come. `hello`, `next` and `counts` are those of LiveSource.
///
/// Trust: layers may be hostile. A layer that does not fit those before it is counted as bad and
/// left out.
class LiveAssembler {
 public:
  using Clock = std::chrono::steady_clock;

  /// A frame that has had no new layer for `patience` is given as it is.
  explicit LiveAssembler(Clock::duration patience = std::chrono::milliseconds(15))
      : patience_(patience) {}

  // For the receiving thread.

  void add(LiveHello hello);
  /// `bytes`: those that `layer.bytes` views. They are kept, not copied.
  void add(const LiveLayer& layer, SharedBytes bytes);
  /// A message that was neither.
  void add_bad();
  /// How many layers the server has left out on this connection.
  void set_dropped(std::uint64_t layers);
  /// What follows comes over a new connection. It begins with a hello and the base of any frame.
  void reconnected();

  // For any thread.

  std::optional<LiveHello> hello(std::chrono::milliseconds timeout);
  std::optional<LiveFrame> next(std::chrono::milliseconds timeout);
  LiveCounts counts() const;
  void cancel();

 private:
  bool newer(std::uint32_t number) const { return !newest_ || number > *newest_; }
  void keep_coming();

  const Clock::duration patience_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  bool cancelled_ = false;
  std::optional<LiveHello> hello_;
  std::optional<LiveFrame> coming_;  ///< layers of it are still missing
  Clock::time_point newest_layer_{};
  std::optional<LiveFrame> come_;        ///< waits to be given
  std::optional<std::uint32_t> newest_;  ///< the frame whose base came last
  std::optional<std::uint32_t> given_;   ///< the frame that was given last
  std::size_t given_layers_ = 0;         ///< how many layers that frame had
  LiveCounts counts_;
  std::uint64_t dropped_before_ = 0;  ///< on earlier connections
};

}  // namespace pointreel
