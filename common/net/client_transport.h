#pragma once

#include <array>
#include <concepts>
#include <cstddef>
#include <memory>
#include <string>
#include <type_traits>
#include <utility>

#include <boost/asio/basic_stream_socket.hpp>
#include <boost/asio/buffer.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/ssl/context.hpp>
#include <boost/beast/core/role.hpp>

/// The client's end of a connection, plain or with TLS, behind functions that are no templates:
/// Asio's and Beast's are compiled for one kind of stream and one kind of handler instead of for
/// all.
namespace pointreel {

/// What an operation calls at its end, once.
class Completion {
 public:
  template <class Handler>
    requires(!std::same_as<std::decay_t<Handler>, Completion>)
  explicit Completion(Handler&& handler)
      : call_(std::make_unique<Of<std::decay_t<Handler>>>(std::forward<Handler>(handler))) {}

  void operator()(boost::system::error_code error, std::size_t size = 0) {
    const auto call = std::move(call_);
    (*call)(error, size);
  }

 private:
  struct Call {
    virtual ~Call() = default;
    virtual void operator()(boost::system::error_code error, std::size_t size) = 0;
  };
  template <class Handler>
  struct Of : Call {
    template <class From>
    explicit Of(From&& from) : handler(std::forward<From>(from)) {}
    void operator()(boost::system::error_code error, std::size_t size) override {
      if constexpr (std::invocable<Handler&, boost::system::error_code, std::size_t>) {
        handler(error, size);
      } else {
        handler(error);
      }
    }
    Handler handler;
  };

  std::unique_ptr<Call> call_;
};

/// Runs on one thread, that of the context.
class ClientTransport {
 public:
  using Executor = boost::asio::io_context::executor_type;
  using Socket = boost::asio::basic_stream_socket<boost::asio::ip::tcp, Executor>;
  /// The first buffers of a sequence; behind them, empty ones.
  template <class Buffer>
  using Pieces = std::array<Buffer, 4>;

  /// Plain if `tls` is null, which need not outlive the transport.
  static std::unique_ptr<ClientTransport> make(boost::asio::io_context& context,
                                               boost::asio::ssl::context* tls);
  virtual ~ClientTransport() = default;

  virtual Socket& socket() = 0;
  /// The handshake of TLS with a server whose certificate must be for `host`. Plain transports do
  /// nothing and call nobody.
  virtual void handshake(const std::string& host, Completion done) = 0;
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
    transport_->read_some(pieces<boost::asio::mutable_buffer>(buffers),
                          Completion(std::forward<Handler>(handler)));
  }
  template <class Buffers, class Handler>
  void async_write_some(const Buffers& buffers, Handler&& handler) {
    transport_->write_some(pieces<boost::asio::const_buffer>(buffers),
                           Completion(std::forward<Handler>(handler)));
  }

 private:
  template <class Buffer, class Buffers>
  static ClientTransport::Pieces<Buffer> pieces(const Buffers& buffers) {
    ClientTransport::Pieces<Buffer> first;
    std::size_t count = 0;
    const auto end = boost::asio::buffer_sequence_end(buffers);
    for (auto at = boost::asio::buffer_sequence_begin(buffers); at != end; ++at) {
      if (count == first.size()) break;
      first[count++] = Buffer(*at);
    }
    return first;
  }

  std::unique_ptr<ClientTransport> transport_;
};

// Beast calls these to close a stream of a type that is not its own.
inline void beast_close_socket(ClientStream& stream) { stream.transport().close(); }
template <class Handler>
void async_teardown(boost::beast::role_type role, ClientStream& stream, Handler&& handler) {
  stream.transport().tear_down(role, Completion(std::forward<Handler>(handler)));
}

}  // namespace pointreel
