#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>

#include "pointreel/error.h"
#include "server/serve/catalog.h"
#include "server/serve/limits.h"
#include "server/serve/listen_address.h"
#include "server/serve/service.h"

namespace pointreel {

struct HttpServerOptions : Limits {
  ListenAddress listen;
  /// PEM files of TLS; none: plain HTTP.
  std::filesystem::path certificate, key;
  unsigned threads = 0;  ///< 0: one for each processor
  ServiceOptions service;
};

/// An HTTP/1.1 server (RFC 9110 to 9112), plain or over TLS, for a catalog: GET, HEAD and OPTIONS,
/// ranges, conditions, keep-alive, pipelining; and, on the same port, live streams over WebSocket.
///
/// Trust: what comes from the network is untrusted. A request's head is bounded (8 KiB) and its
/// body refused. A connection holds at most that head, a response's head and one open file: files
/// go from the page cache to the socket in pieces, and the unsent part of the socket's buffer is
/// bounded, so a reader that stalls costs next to nothing and blocks nobody.
class HttpServer {
 public:
  /// Listens and serves in threads of its own; returns when connections are accepted. The error
  /// says that the address is in use, not this machine's, or not permitted, or what is wrong with
  /// the certificate.
  /// `relay` may be null: no live streams. Else it must outlive the server.
  static Result<std::unique_ptr<HttpServer>> start(Catalog catalog,
                                                   const HttpServerOptions& options,
                                                   Relay* relay = nullptr);
  ~HttpServer();
  HttpServer(const HttpServer&) = delete;
  HttpServer& operator=(const HttpServer&) = delete;

  /// The address listened on, with the real port.
  const ListenAddress& address() const;
  std::uint16_t port() const { return address().port; }
  /// Connections that are open now, those that are being refused not counted.
  std::size_t connection_count() const;
  /// Closes the listening socket and every connection, and waits for the threads. Idempotent.
  void stop();

 private:
  struct State;
  explicit HttpServer(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace pointreel
