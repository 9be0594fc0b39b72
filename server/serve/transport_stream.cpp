#include "server/serve/asio_types.h"
// After the header that configures Asio.
#include "server/serve/transport_stream.h"

namespace pointreel {
namespace {

template <class Buffer>
struct Operation {
  static constexpr bool kReads = std::same_as<Buffer, asio::mutable_buffer>;

  std::shared_ptr<Transport> transport;
  Pieces<Buffer> pieces;
  Completion done;
  enum class At { kBegin, kPlain, kWaiting, kPosted } at = At::kBegin;
  std::size_t moved = 0;

  void operator()(error_code error = {}, std::size_t size = 0) {
    switch (at) {
      case At::kBegin:
        if (!kReads) transport->set_stall_deadline();
        if (transport->tls() == nullptr) return begin_plain();
        break;
      case At::kPlain:
        return complete(error, size);
      case At::kWaiting:
        if (error) return complete(error, 0);
        break;
      case At::kPosted:
        return complete({}, moved);
    }
    encrypted_step();
  }

 private:
  void begin_plain() {
    at = At::kPlain;
    Socket& socket = transport->socket();
    const Pieces<Buffer> copy = pieces;  // they move with the operation
    if constexpr (kReads) {
      socket.async_read_some(copy, std::move(*this));
    } else {
      socket.async_write_some(copy, std::move(*this));
    }
  }

  void complete(error_code error, std::size_t size) {
    if (!kReads) transport->suspend_deadline();
    done(error, size);
  }

  void encrypted_step() {
    Socket& socket = transport->socket();
    // Once the socket is closed, the descriptor that TLS holds may belong to another connection.
    if (!socket.is_open()) return finish(asio::error::operation_aborted);
    TlsSession::Step step;
    for (const Buffer& piece : pieces) {
      if (piece.size() == 0) continue;
      if constexpr (kReads) {
        step = transport->tls()->read({static_cast<char*>(piece.data()), piece.size()});
      } else {
        step = transport->tls()->write({static_cast<const char*>(piece.data()), piece.size()});
      }
      break;
    }
    moved = step.bytes;
    if (step.want == TlsSession::Step::Want::kEnd) return finish(asio::error::eof);
    if (step.want == TlsSession::Step::Want::kNothing) {
      if (at == At::kWaiting) return complete({}, moved);
      at = At::kPosted;  // handlers must not be called from within the initiating function
      const Strand strand = transport->executor();  // `transport` moves with the operation
      asio::post(strand, std::move(*this));
      return;
    }
    at = At::kWaiting;
    socket.async_wait(
        step.want == TlsSession::Step::Want::kRead ? Socket::wait_read : Socket::wait_write,
        std::move(*this));
  }

  void finish(error_code error) {
    if (at == At::kWaiting) return complete(error, 0);
    at = At::kPlain;
    const Strand strand = transport->executor();
    asio::post(strand, [self = std::move(*this), error]() mutable { self(error, 0); });
  }
};

}  // namespace

void TransportStream::read_some(const Pieces<asio::mutable_buffer>& into, Completion done) {
  Operation<asio::mutable_buffer>{transport_, into, std::move(done)}();
}

void TransportStream::write_some(const Pieces<asio::const_buffer>& from, Completion done) {
  Operation<asio::const_buffer>{transport_, from, std::move(done)}();
}

}  // namespace pointreel
