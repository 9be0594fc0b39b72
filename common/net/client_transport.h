#pragma once

#include <memory>
#include <string>
#include <utility>

#include <boost/asio/basic_stream_socket.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/ssl/context.hpp>
#include <boost/beast/core/role.hpp>

#include "common/net/stream_operation.h"

namespace pointreel {

/// The client's end of a connection, plain or with TLS. Runs on one thread, that of the context.
class ClientTransport {
 public:
  using Executor = boost::asio::io_context::executor_type;
  using Socket = boost::asio::basic_stream_socket<boost::asio::ip::tcp, Executor>;

  /// Plain if `tls` is null, which need not outlive the transport.
  static std::unique_ptr<ClientTransport> make(boost::asio::io_context& context,
                                               boost::asio::ssl::context* tls);
  virtual ~ClientTransport() = default;

  virtual Socket& socket() = 0;
  /// The handshake of TLS with a server whose certificate must be for `host`. Plain transports do
  /// nothing and call nobody.
  virtual void handshake(const std::string& host, Completion done) = 0;
  /// Why the handshake did not trust the server's certificate, in OpenSSL's words; empty if it did.
  virtual std::string distrust() = 0;
  virtual void read_some(const Pieces<boost::asio::mutable_buffer>& into, Completion done) = 0;
  virtual void write_some(const Pieces<boost::asio::const_buffer>& from, Completion done) = 0;
  virtual void tear_down(boost::beast::role_type role, Completion done) = 0;
  void close();
};

/// A transport as Beast requires it (an AsyncStream).
class ClientStream {
 public:
  using executor_type = ClientTransport::Executor;
  explicit ClientStream(std::unique_ptr<ClientTransport> transport)
      : transport_(std::move(transport)) {}
  executor_type get_executor() const { return transport_->socket().get_executor(); }
  ClientTransport& transport() { return *transport_; }

  template <class Buffers, class Handler>
  void async_read_some(const Buffers& buffers, Handler&& handler) {
    transport_->read_some(first_pieces<boost::asio::mutable_buffer>(buffers),
                          Completion(std::forward<Handler>(handler)));
  }
  template <class Buffers, class Handler>
  void async_write_some(const Buffers& buffers, Handler&& handler) {
    transport_->write_some(first_pieces<boost::asio::const_buffer>(buffers),
                           Completion(std::forward<Handler>(handler)));
  }

 private:
  std::unique_ptr<ClientTransport> transport_;
};

// Beast calls these to close a stream of a type that is not its own.
inline void beast_close_socket(ClientStream& stream) { stream.transport().close(); }
template <class Handler>
void async_teardown(boost::beast::role_type role, ClientStream& stream, Handler&& handler) {
  stream.transport().tear_down(role, Completion(std::forward<Handler>(handler)));
}

}  // namespace pointreel
