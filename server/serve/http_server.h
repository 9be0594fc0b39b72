#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string_view>

#include "pointreel/error.h"
#include "server/serve/listen_address.h"
#include "server/service/catalog.h"
#include "server/service/limits.h"
#include "server/service/service.h"

namespace pointreel {

struct HttpServerOptions : Limits {
  ListenAddress listen;
  /// PEM files for TLS; empty: plain HTTP.
  std::filesystem::path certificate, key;
  unsigned threads = 0;  ///< 0: one for each processor
  ServiceOptions service;
};

/// An HTTP/1.1 server (RFC 9110 to 9112), plain or over TLS, that serves a catalog: GET, HEAD and
/// OPTIONS, ranges, conditions, keep-alive and pipelining. It serves live streams over WebSocket on
/// the same port.
///
/// Trust: everything from the network is untrusted. The head of a request is bounded (8 KiB), and a
/// body is refused. A connection holds at most that head, the head of a response and one open file.
/// Files go from the page cache to the socket in pieces, and the unsent part of the socket's buffer
/// is bounded, so a peer that stalls costs next to nothing and never delays others.
class HttpServer {
 public:
  /// Starts to listen and to serve in threads of its own, and returns when connections are
  /// accepted. An error if the address is in use, does not belong to this machine or is not
  /// permitted, or if the certificate cannot be used. `relay` must outlive the server; null: no
  /// live streams.
  static Result<std::unique_ptr<HttpServer>> start(Catalog catalog,
                                                   const HttpServerOptions& options,
                                                   Relay* relay = nullptr);
  ~HttpServer();
  HttpServer(const HttpServer&) = delete;
  HttpServer& operator=(const HttpServer&) = delete;

  /// The address listened on, with the real port.
  const ListenAddress& address() const;
  std::uint16_t port() const { return address().port; }
  /// The number of open connections, not counting those that are being refused.
  std::size_t connection_count() const;
  /// Reads the certificate and its key again, for all connections from now on. On an error those
  /// before stay in use. A server without TLS stays without, and one with TLS keeps it.
  Result<void> read_certificate(const std::filesystem::path& certificate,
                                const std::filesystem::path& key);
  /// Replaces the tokens, for all requests from now on. Connections to live streams stay.
  void set_tokens(std::string_view view_token, std::string_view publish_token);
  /// Closes the listening socket and every connection, and waits for the threads. Idempotent.
  void stop();

 private:
  struct State;
  explicit HttpServer(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace pointreel
