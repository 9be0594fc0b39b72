#pragma once

#include <memory>
#include <utility>

#include <boost/asio/post.hpp>
#include <boost/beast/core/role.hpp>

#include "common/net/stream_operation.h"
#include "server/serve/transport.h"

// Sources must include asio_types.h before this header, because it configures Asio.
namespace pointreel {

/// A transport as Beast requires it (an AsyncStream). The peer must accept each piece that is
/// written within the transport's stall time. Operations that are under way keep the transport
/// alive: Beast's pings belong to nobody, and may end after the session that they were sent for.
class TransportStream {
 public:
  using executor_type = Strand;
  explicit TransportStream(std::shared_ptr<Transport> transport)
      : transport_(std::move(transport)) {}
  executor_type get_executor() const { return transport_->executor(); }
  Transport& transport() { return *transport_; }

  template <class Buffers, class Handler>
  void async_read_some(const Buffers& buffers, Handler&& handler) {
    read_some(first_pieces<asio::mutable_buffer>(buffers),
              Completion(std::forward<Handler>(handler)));
  }
  template <class Buffers, class Handler>
  void async_write_some(const Buffers& buffers, Handler&& handler) {
    write_some(first_pieces<asio::const_buffer>(buffers),
               Completion(std::forward<Handler>(handler)));
  }

 private:
  void read_some(const Pieces<asio::mutable_buffer>& into, Completion done);
  void write_some(const Pieces<asio::const_buffer>& from, Completion done);

  std::shared_ptr<Transport> transport_;
};

// Beast calls these to close a stream of a type that is not its own.
inline void beast_close_socket(TransportStream& stream) { stream.transport().close(); }
template <class Handler>
void async_teardown(boost::beast::role_type, TransportStream& stream, Handler&& handler) {
  stream.transport().end_writing();
  asio::post(stream.get_executor(),
             [handler = std::forward<Handler>(handler)]() mutable { handler(error_code()); });
}

}  // namespace pointreel
