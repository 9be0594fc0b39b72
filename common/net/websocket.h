#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <stop_token>
#include <string>

#include "common/net/url.h"
#include "pointreel/bytes.h"
#include "pointreel/error.h"

/// A WebSocket client (RFC 6455), for publishers and viewers of live streams.
namespace pointreel {

/// Parses ws://HOST[:PORT]/PATH or wss://... Fails with `argument` for any other address, and for
/// one that names a user.
Result<Url> parse_websocket_url(const std::string& url);

struct WebSocketOptions {
  std::string token;                 ///< sent as `Authorization: Bearer` unless empty
  std::string option_prefix = "--";  ///< errors name the options with it: "--relay-" of relays
  std::string ca_file;  ///< wss: a PEM file of certificates to trust instead of the system's
  std::chrono::milliseconds connect_timeout{5'000};  ///< for everything up to the upgrade
  /// The connection counts as lost if the peer sends nothing for this long, not even the answer to
  /// a ping. What connecting took is added, so that a slow link does not look like a lost one.
  std::chrono::milliseconds silence_timeout{2'000};
  /// The connection counts as lost if the peer acknowledges none of the sent data for this long. 0
  /// leaves it to the system.
  std::chrono::milliseconds stall_timeout{0};
  std::size_t max_message = 64u << 20;  ///< in bytes; a longer one ends the connection
  /// In bytes of memory, which empty messages take, too. If more messages than this wait for
  /// receive(), reading pauses until some are taken.
  std::size_t max_waiting = 64u << 20;
  bool confirm = false;  ///< find out what the peer has read, for confirmed()
  std::stop_token stop;  ///< makes connecting fail soon, with `cancelled`
};

struct WebSocketMessage {
  enum class Kind : std::uint8_t { text, binary };
  Kind kind = Kind::binary;
  Bytes bytes;
};

/// Fails with `argument` if WebSocket::connect() would do so, whatever the server does.
Result<void> check_websocket(const std::string& url, const WebSocketOptions& options);

/// A connection, with a thread of its own. One thread may send while another receives.
///
/// Trust: the peer may be hostile. The size of a message is bounded by max_message before memory is
/// taken for it, and waiting messages are bounded by max_waiting. Data that are not valid WebSocket
/// frames end the connection.
class WebSocket {
 public:
  using Kind = WebSocketMessage::Kind;

  /// Errors begin with HOST:PORT. Their codes are `argument` for a bad URL or certificate file,
  /// code_of_status() if the server answers but does not upgrade, `cancelled`, and otherwise `io`.
  static Result<std::unique_ptr<WebSocket>> connect(const std::string& url,
                                                    const WebSocketOptions& options = {});

  /// Closes the connection and waits for that, at most half a second.
  virtual ~WebSocket() = default;

  /// Sends one message, which consists of these pieces in this order. Returns once the message is
  /// handed to the system. Fails if the connection has ended.
  virtual Result<void> send(std::span<const ByteView> pieces, Kind kind) = 0;
  Result<void> send(ByteView message, Kind kind) { return send({&message, 1}, kind); }

  /// How many of the messages sent the peer is known to have read. With WebSocketOptions::confirm,
  /// pings are sent behind messages, one at a time: a peer answers them in their order. Otherwise
  /// 0.
  virtual std::uint64_t confirmed() const = 0;

  /// The next message, or nothing after the timeout. Once the connection has ended and all messages
  /// are taken, fails with the reason, which is the peer's if it gave one: `cancelled` after
  /// close(), `limit` if a message was too long, otherwise `io`.
  virtual Result<std::optional<WebSocketMessage>> receive(std::chrono::milliseconds timeout) = 0;
  /// How many messages wait for receive().
  virtual std::size_t waiting() const = 0;

  /// Ends the connection; callable from any thread. Sent messages are still delivered if that does
  /// not take long. Pending and later calls fail.
  virtual void close() = 0;
};

}  // namespace pointreel
