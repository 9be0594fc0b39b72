#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "common/stream/live.h"
#include "common/stream/live_queue.h"
#include "pointreel/error.h"
#include "server/relay/relay.h"

namespace pointreel {

/// A viewer as its stream sees it.
struct Seat {
  LiveQueue queue;
  std::function<void()> wake;
  bool asleep = false;  ///< the viewer was told that nothing waits
};

/// One stream of the relay. Each has a lock of its own, so that streams do not wait for each other.
/// Publishers are told apart by their addresses, `publisher`.
class Stream {
 public:
  Stream(std::string name, const LiveQueueOptions& options,
         std::vector<std::shared_ptr<LiveSink>> sinks)
      : name_(std::move(name)), options_(options), sinks_(std::move(sinks)) {}

  /// Takes a message of a publisher. A new publisher owns the stream once its hello is accepted.
  Result<void> message(const void* publisher, LiveMessage message);
  void leave(const void* publisher);

  std::shared_ptr<Seat> join(std::function<void()> wake);
  void leave(const std::shared_ptr<Seat>& seat);
  std::optional<LiveMessage> next(Seat& seat);

  StreamStatistics statistics() const;

 private:
  Result<void> text(const void* publisher, LiveMessage message);
  Result<void> layer(LiveMessage message);
  static void wake(Seat& seat);

  const std::string name_;
  const LiveQueueOptions options_;
  const std::vector<std::shared_ptr<LiveSink>> sinks_;
  mutable std::mutex mutex_;  // guards what follows, including the seats
  const void* owner_ = nullptr;
  const void* replaced_ = nullptr;  ///< the owner whose place the present one has taken
  bool resent_ = false;  ///< the publisher has reconnected, and nothing new has come since
  LiveHello parsed_hello_;
  LiveMessage hello_;
  LiveLayer last_;                   ///< without its bytes
  std::vector<LiveMessage> newest_;  ///< layers of the newest frame
  std::vector<std::shared_ptr<Seat>> seats_;
  std::uint64_t frames_ = 0, layers_ = 0, bytes_ = 0, sent_bytes_ = 0;
  LiveDrops drops_of_gone_;  ///< of viewers that have left
};

}  // namespace pointreel
