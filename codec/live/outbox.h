#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <mutex>
#include <optional>
#include <stop_token>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "codec/live/live_queue.h"
#include "common/net/websocket.h"
#include "pointreel/error.h"

namespace pointreel {

struct OutboxOptions {
  std::string url;  ///< ws(s)://HOST/live/NAME?publish
  std::string token, ca_file;
  /// Called with one line whenever the state of the connection changes, from the outbox's thread.
  /// May be empty.
  std::function<void(const std::string& line)> say;
};

struct OutboxStatistics {
  std::uint64_t connections = 0;        ///< connections that were established
  std::uint64_t layers = 0, bytes = 0;  ///< sent
  /// Frames, at least their bases, and layers that the server has accepted.
  std::uint64_t accepted_frames = 0, accepted_layers = 0;
  LiveDrops drops;  ///< not sent, because the link was too slow or there was none
};

/// A publisher's connection to a server, with a thread of its own. It sends what is pushed as far
/// as the link allows, and otherwise what a LiveQueue leaves of it. If the connection breaks, it is
/// established again, as often as necessary, and begins with the newest frame.
class Outbox {
 public:
  explicit Outbox(OutboxOptions options);
  ~Outbox();
  Outbox(const Outbox&) = delete;
  Outbox& operator=(const Outbox&) = delete;

  void hello(LiveMessage message);
  /// The layers of the next frame, base first.
  void push(std::uint32_t frame, std::vector<LiveMessage> layers);

  /// A packet of sound (live_sound.h). Before the first hello, it is lost.
  void sound(LiveMessage message);

  /// Waits until the first attempt to connect has ended, whether it worked or not.
  void wait_until_tried(const std::stop_token& stop);
  /// The reason why nothing can ever be sent, such as a token that was never valid; nothing if
  /// there is none.
  std::optional<Error> failure() const;
  /// Why nothing can be sent at present; empty if nothing is known to be wrong.
  std::string trouble() const;
  /// Waits until the server has accepted everything that was pushed and not dropped, but no longer
  /// than this.
  void flush(std::chrono::milliseconds timeout);
  OutboxStatistics statistics() const;

 private:
  void run(const std::stop_token& stop);
  /// Sends until the connection ends.
  void serve(WebSocket& socket, const std::stop_token& stop);
  void restart();
  void tell(const std::string& trouble);
  void count_accepted(std::uint64_t confirmed);

  const OutboxOptions options_;
  mutable std::mutex mutex_;  // guards what follows
  std::condition_variable_any changed_;
  LiveQueue queue_;
  LiveMessage hello_;
  std::vector<LiveMessage> newest_;  ///< layers of the newest frame
  std::uint32_t frame_ = 0;
  bool sending_ = false;
  /// A layer that was sent over this connection, and is not known to be accepted.
  struct Sent {
    std::uint64_t message = 0;                     ///< how many messages were sent with it
    std::pair<std::uint32_t, std::uint8_t> layer;  ///< the numbers of its frame and of itself
  };
  std::deque<Sent> unconfirmed_;
  std::optional<std::pair<std::uint32_t, std::uint8_t>> accepted_;  ///< the last one
  std::optional<Error> failure_;
  OutboxStatistics statistics_;
  std::string trouble_;  ///< empty while the server accepts what is sent
  std::jthread thread_;
};

}  // namespace pointreel
