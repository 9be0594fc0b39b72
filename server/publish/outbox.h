#pragma once

#include <condition_variable>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <stop_token>
#include <string>
#include <thread>
#include <vector>

#include "common/net/websocket.h"
#include "server/relay/viewer_queue.h"

namespace pointreel {

struct OutboxOptions {
  std::string url;  ///< ws(s)://HOST/live/NAME, as publishers are told
  std::string token, ca_file;
  /// Told what becomes of the connection, one line each, from the outbox's thread. May be empty.
  std::function<void(const std::string& line)> say;
};

struct OutboxStatistics {
  std::uint64_t connections = 0;  ///< that were made
  std::uint64_t layers = 0, bytes = 0;
  LiveDrops drops;  ///< that the link did not take in time
};

/// A publisher's connection, with a thread of its own: sends what is pushed, as far as the link
/// takes it, and otherwise what a ViewerQueue leaves. Where the connection is lost it is made
/// again, as often as it takes, with the newest frame first.
class Outbox {
 public:
  explicit Outbox(OutboxOptions options);
  ~Outbox();
  Outbox(const Outbox&) = delete;
  Outbox& operator=(const Outbox&) = delete;

  void hello(LiveMessage message);
  /// The layers of the next frame, base first.
  void push(std::uint32_t frame, std::vector<LiveMessage> layers);

  /// Why nothing will ever be sent, such as a token that is not taken; nothing while all may be
  /// well yet.
  std::optional<Error> failure() const;
  /// Waits until all that was pushed is sent, or for so long.
  void flush(std::chrono::milliseconds timeout);
  OutboxStatistics statistics() const;

 private:
  void run(const std::stop_token& stop);
  /// Returns when the connection has ended.
  void serve(WebSocket& socket, const std::stop_token& stop);
  void restart();
  void tell(const std::string& line);

  const OutboxOptions options_;
  mutable std::mutex mutex_;  // of what follows
  std::condition_variable_any changed_;
  ViewerQueue queue_;
  LiveMessage hello_;
  std::vector<LiveMessage> newest_;  ///< layers of the newest frame
  std::uint32_t frame_ = 0;
  bool sending_ = false;
  std::optional<Error> failure_;
  OutboxStatistics statistics_;
  std::string told_;  ///< of the thread: the last line
  std::jthread thread_;
};

}  // namespace pointreel
