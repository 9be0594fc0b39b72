#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "codec/live/live.h"
#include "codec/live/live_queue.h"
#include "pointreel/error.h"
#include "server/relay/relay.h"
#include "server/relay/session.h"

namespace pointreel {

/// A viewer as its stream sees it.
struct Seat {
  LiveQueue queue;
  std::function<void()> wake;
  bool sound = false;   ///< the viewer wants sound
  bool asleep = false;  ///< the viewer was told that nothing waits
};

/// One stream of the relay. Each has a lock of its own, so that streams do not wait for each other.
/// Connections of publishers are told apart by their addresses, `publisher`, and publishers by the
/// proofs of their secrets.
class Stream {
 public:
  using Time = RelayOptions::Clock::time_point;

  Stream(std::string name, const LiveQueueOptions& options,
         std::vector<std::shared_ptr<LiveSink>> sinks)
      : name_(std::move(name)), options_(options), sinks_(std::move(sinks)) {}

  /// Takes the hello of a publisher, which owns the stream if it is accepted. The session is that
  /// of the proof. Whoever proves to be the earlier owner takes the name over. `may_replace`:
  /// another connection with one of these proofs is older, and is replaced.
  Result<void> hello(const void* publisher, LiveHello hello, const SessionProofs& proofs,
                     bool may_replace, Time now);
  /// Takes a layer from a publisher.
  Result<void> layer(const void* publisher, LiveMessage message);
  /// So much more was lost on the way from the publisher to this server.
  void lost(const LiveDrops& drops);
  /// Takes a packet of sound from a publisher. One that has come before is left out.
  Result<void> sound(const void* publisher, LiveMessage message);
  /// The publisher's connection has ended. Its name is reserved for it until then.
  void leave(const void* publisher, Time reserved_until);
  /// Whether the stream belongs to a publisher, be it connected or not.
  bool is_owned(Time now) const;
  bool is_publishing() const;

  std::shared_ptr<Seat> join(std::function<void()> wake, bool sound);
  void leave(const std::shared_ptr<Seat>& seat);
  std::optional<LiveMessage> next(Seat& seat);

  StreamStatistics statistics() const;

 private:
  Result<void> check_frame(const LiveLayer& layer);
  static void wake(Seat& seat);

  const std::string name_;
  /// Made beforehand, because a publisher also leaves when there is no memory.
  const LiveMessage end_ = text_message(write_end());
  const LiveQueueOptions options_;
  const std::vector<std::shared_ptr<LiveSink>> sinks_;
  mutable std::mutex mutex_;  // guards what follows, including the seats
  const void* owner_ = nullptr;
  std::optional<SessionProof> proof_;  ///< of the publisher that owns the stream, or did last
  Time reserved_until_ = Time::min();  ///< for that publisher, while it is not connected
  bool resent_ = false;  ///< the publisher has reconnected, and nothing new has come since
  LiveHello parsed_hello_;
  LiveMessage hello_;                        ///< as viewers get it
  Box cubes_;                                ///< of all frames of the session
  LiveLayer last_;                           ///< without its bytes
  std::vector<LiveMessage> newest_;          ///< layers of the newest frame
  std::optional<std::uint32_t> last_sound_;  ///< number of the newest packet of the session
  std::vector<std::shared_ptr<Seat>> seats_;
  std::uint64_t frames_ = 0, layers_ = 0, bytes_ = 0, sent_bytes_ = 0;
  LiveDrops drops_of_gone_;  ///< of viewers that have left
  LiveDrops lost_;
  std::int64_t lag_us_ = 0;  ///< from the capture of the newest frame until its base was here
};

}  // namespace pointreel
