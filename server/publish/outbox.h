#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <mutex>
#include <optional>
#include <stop_token>
#include <string>
#include <thread>
#include <vector>

#include "common/net/websocket.h"
#include "common/stream/live_queue.h"
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
  LiveDrops drops;                      ///< not sent, because the link was too slow
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

  /// The reason why nothing can ever be sent, such as a wrong token; nothing if there is none.
  std::optional<Error> failure() const;
  /// Waits until everything that was pushed has been sent, but no longer than this.
  void flush(std::chrono::milliseconds timeout);
  OutboxStatistics statistics() const;

 private:
  void run(const std::stop_token& stop);
  /// Sends until the connection ends.
  void serve(WebSocket& socket, const std::stop_token& stop);
  void restart();
  void tell(const std::string& line);

  const OutboxOptions options_;
  mutable std::mutex mutex_;  // guards what follows
  std::condition_variable_any changed_;
  LiveQueue queue_;
  LiveMessage hello_;
  std::vector<LiveMessage> newest_;  ///< layers of the newest frame
  std::uint32_t frame_ = 0;
  bool sending_ = false;
  std::optional<Error> failure_;
  OutboxStatistics statistics_;
  std::string told_;  ///< the last line; used by the thread only
  std::jthread thread_;
};

}  // namespace pointreel
