#pragma once

#include <memory>
#include <utility>

#include <boost/asio/buffer.hpp>
#include <boost/asio/compose.hpp>
#include <boost/asio/post.hpp>
#include <boost/beast/core/role.hpp>

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

  template <class Buffers, class Token>
  auto async_read_some(const Buffers& buffers, Token&& token) {
    return asio::async_compose<Token, void(error_code, std::size_t)>(
        Operation<Buffers, true>{transport_, buffers}, token, get_executor());
  }
  template <class Buffers, class Token>
  auto async_write_some(const Buffers& buffers, Token&& token) {
    return asio::async_compose<Token, void(error_code, std::size_t)>(
        Operation<Buffers, false>{transport_, buffers}, token, get_executor());
  }

 private:
  template <class Buffers, bool kReads>
  struct Operation {
    std::shared_ptr<Transport> transport;
    Buffers buffers;
    enum class At { kBegin, kPlain, kWaiting, kPosted } at = At::kBegin;
    std::size_t moved = 0;

    template <class Self>
    void operator()(Self& self, error_code error = {}, std::size_t size = 0) {
      switch (at) {
        case At::kBegin:
          if (!kReads) transport->set_stall_deadline();
          if (transport->tls() == nullptr) {
            at = At::kPlain;
            const Buffers copy = buffers;
            if constexpr (kReads) {
              transport->socket().async_read_some(copy, std::move(self));
            } else {
              transport->socket().async_write_some(copy, std::move(self));
            }
            return;
          }
          break;
        case At::kPlain:
          return complete(self, error, size);
        case At::kWaiting:
          if (error) return complete(self, error, 0);
          break;
        case At::kPosted:
          return complete(self, {}, moved);
      }
      encrypted_step(self);
    }

   private:
    template <class Self>
    void complete(Self& self, error_code error, std::size_t size) {
      if (!kReads) transport->suspend_deadline();
      self.complete(error, size);
    }

    template <class Self>
    void encrypted_step(Self& self) {
      using Want = TlsSession::Step::Want;
      // Once the socket is closed, the descriptor that TLS holds may belong to another connection.
      if (!transport->socket().is_open()) return finish(self, asio::error::operation_aborted);
      TlsSession::Step step;
      const auto end = asio::buffer_sequence_end(buffers);
      for (auto it = asio::buffer_sequence_begin(buffers); it != end; ++it) {
        if constexpr (kReads) {
          const asio::mutable_buffer buffer(*it);
          if (buffer.size() == 0) continue;
          step = transport->tls()->read({static_cast<char*>(buffer.data()), buffer.size()});
        } else {
          const asio::const_buffer buffer(*it);
          if (buffer.size() == 0) continue;
          step = transport->tls()->write({static_cast<const char*>(buffer.data()), buffer.size()});
        }
        break;
      }
      moved = step.bytes;
      if (step.want == Want::kEnd) return finish(self, asio::error::eof);
      if (step.want == Want::kNothing) {
        if (at == At::kWaiting) return complete(self, {}, moved);
        at = At::kPosted;  // handlers must not be called from within the initiating function
        asio::post(transport->executor(), std::move(self));
        return;
      }
      at = At::kWaiting;
      transport->socket().async_wait(
          step.want == Want::kRead ? Socket::wait_read : Socket::wait_write, std::move(self));
    }

    template <class Self>
    void finish(Self& self, error_code error) {
      if (at == At::kWaiting) return complete(self, error, 0);
      at = At::kPlain;
      const Strand strand = transport->executor();  // `transport` moves with `self`
      asio::post(strand, [self = std::move(self), error]() mutable { self(error, 0); });
    }
  };

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
