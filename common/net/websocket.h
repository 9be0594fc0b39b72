#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>

#include "common/net/url.h"
#include "common/stream/live.h"
#include "pointreel/bytes.h"
#include "pointreel/error.h"

/// A WebSocket client (RFC 6455), for publishers and viewers of live streams.
namespace pointreel {

/// ws://HOST[:PORT]/PATH or wss://...; refuses any other address, and one that names a user.
Result<Url> parse_websocket_url(const std::string& url);

struct WebSocketOptions {
  std::string token;    ///< sent as `Authorization: Bearer`, unless empty
  std::string ca_file;  ///< wss: certificates to trust in PEM, instead of the system's
  std::chrono::milliseconds connect_timeout{5'000};  ///< until the upgrade is answered
  /// Without anything from the peer, which is asked by pings, the connection counts as lost.
  std::chrono::milliseconds silence_timeout{2'000};
  /// The same without the peer taking any of what was sent. 0: for as long as the system tries.
  std::chrono::milliseconds stall_timeout{0};
  std::size_t max_message = kLiveHeaderSize + kMaxLiveLayer;  ///< a longer one ends the connection
  /// Bytes of messages that wait for receive(); then nothing is read until some are taken.
  std::size_t max_waiting = 64u << 20;
  std::stop_token stop;  ///< connecting fails soon
};

struct WebSocketMessage {
  enum class Kind : std::uint8_t { text, binary };
  Kind kind = Kind::binary;
  Bytes bytes;
};

struct ConnectError : Error {
  int status = 0;  ///< of HTTP, if the server answered, but with something else than 101
};

/// One connection. It has a thread of its own; one thread may send while another receives.
///
/// Trust: the peer is not trusted. A message is bounded by max_message before memory is taken for
/// it, and what waits by max_waiting; anything that is no WebSocket ends the connection.
class WebSocket {
 public:
  using Kind = WebSocketMessage::Kind;

  /// Errors begin with HOST:PORT.
  static tl::expected<std::unique_ptr<WebSocket>, ConnectError> connect(
      const std::string& url, const WebSocketOptions& options = {});

  /// As `close`, at most half a second.
  virtual ~WebSocket() = default;

  /// Returns when the system has taken the message. An error if the connection has ended.
  virtual Result<void> send(ByteView message, Kind kind) = 0;

  /// The next message, or nothing after the timeout. Once the connection has ended, and what came
  /// before is taken, an error that says how: with the peer's reason, if it gave one.
  virtual Result<std::optional<WebSocketMessage>> receive(std::chrono::milliseconds timeout) = 0;

  /// From any thread: ends the connection. What was sent still goes, if that is soon. Calls under
  /// way and later ones fail.
  virtual void close() = 0;
};

}  // namespace pointreel
