#include "server/serve/websocket_session.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdint>
#include <string_view>
#include <utility>

#include <boost/asio/buffer.hpp>
#include <boost/asio/compose.hpp>
#include <boost/asio/detached.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/redirect_error.hpp>
#include <boost/beast/core/role.hpp>
#include <boost/beast/websocket/error.hpp>
#include <boost/beast/websocket/stream.hpp>
#include <fmt/format.h>
#include <linux/sockios.h>
#include <netinet/tcp.h>
#include <sys/ioctl.h>
#include <sys/socket.h>

#include "pointreel/bytes.h"

namespace pointreel {
namespace {

namespace beast = boost::beast;
namespace websocket = boost::beast::websocket;

/// Bytes that the kernel may hold for a viewer beyond what is in flight. What it holds cannot be
/// dropped any more, so a slow viewer sees it late: at 1 Mbit/s this is an eighth of a second.
constexpr int kUnsentLimit = 16 * 1024;
/// A viewer has nothing to say.
constexpr std::size_t kMaxViewerMessage = 64 * 1024;

/// A transport as Beast wants it (its AsyncStream). Each piece that is written must be taken before
/// the transport's stall time ends.
class TransportStream {
 public:
  using executor_type = Strand;
  explicit TransportStream(Transport& transport) : transport_(&transport) {}
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
    Transport* transport;
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
      // The descriptor that TLS knows is another connection's once the socket is closed.
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
        at = At::kPosted;  // a handler is never called from within the call that begins
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
      asio::post(transport->executor(),
                 [self = std::move(self), error]() mutable { self(error, 0); });
    }
  };

  Transport* transport_;
};

// How Beast ends a stream that it does not know.
void beast_close_socket(TransportStream& stream) { stream.transport().close(); }
template <class Handler>
void async_teardown(beast::role_type, TransportStream& stream, Handler&& handler) {
  stream.transport().end_writing();
  asio::post(stream.get_executor(),
             [handler = std::forward<Handler>(handler)]() mutable { handler(error_code()); });
}

using Stream = websocket::stream<TransportStream, false>;  // without compression

/// A publisher whose machine or link has gone without a word must not keep its stream's name from
/// the next one for long.
constexpr std::chrono::milliseconds kPublisherSilence{5'000};

/// Shared by the coroutines that read and write. It ends when the last of them does.
struct Session {
  Session(std::shared_ptr<Transport> on, const Limits& limits, bool publishes)
      : transport(std::move(on)) {
    const auto silence =
        publishes ? std::min(limits.idle_timeout, kPublisherSilence) : limits.idle_timeout;
    stream.set_option(websocket::stream_base::timeout{limits.header_timeout, silence,
                                                      /*keep_alive_pings=*/true});
    stream.set_option(websocket::stream_base::decorator([](websocket::response_type& response) {
      response.set(beast::http::field::server, "pointreel");
    }));
    stream.auto_fragment(false);
  }

  std::shared_ptr<Transport> transport;
  Stream stream{TransportStream(*transport)};
};

/// Sends what the relay has for a viewer, for as long as it takes it.
Task<void> write_messages(std::shared_ptr<Session> session, std::unique_ptr<Viewer> viewer,
                          std::shared_ptr<Wake> wake) {
  Socket& socket = session->transport->socket();
  ::setsockopt(socket.native_handle(), IPPROTO_TCP, TCP_NOTSENT_LOWAT, &kUnsentLimit,
               sizeof(kUnsentLimit));
  error_code error;
  while (!error && socket.is_open()) {
    // What is newest is decided as late as possible.
    int unsent = 0;
    if (::ioctl(socket.native_handle(), SIOCOUTQNSD, &unsent) == 0 && unsent >= kUnsentLimit) {
      session->transport->set_stall_deadline();
      co_await socket.async_wait(Socket::wait_write, asio::redirect_error(kUseAwaitable, error));
      session->transport->suspend_deadline();
      continue;
    }
    const auto message = viewer->next();
    if (!message) {
      co_await wake->sleep();
      continue;
    }
    session->stream.text(message->kind == LiveMessage::Kind::text);
    co_await session->stream.async_write(
        asio::buffer(message->bytes->data(), message->bytes->size()),
        asio::redirect_error(kUseAwaitable, error));
  }
}

/// Reads, and drops, what a viewer says, until it ends.
Task<void> read_from_viewer(std::shared_ptr<Session> session) {
  session->stream.read_message_max(kMaxViewerMessage);
  std::array<char, 4096> dropped;
  error_code error;
  while (!error) {
    co_await session->stream.async_read_some(asio::buffer(dropped),
                                             asio::redirect_error(kUseAwaitable, error));
  }
}

/// Hands a publisher's messages to the relay. What went wrong, to be told it; empty if it ended.
Task<std::string> read_from_publisher(std::shared_ptr<Session> session, Publication& publication,
                                      const Limits& limits) {
  session->stream.read_message_max(limits.max_message);
  Timer pause(session->transport->executor());
  Clock::time_point paid = Clock::now();  // what came is paid for until then
  while (true) {
    Bytes bytes;
    auto buffer = asio::dynamic_buffer(bytes, limits.max_message);
    error_code error;
    co_await session->stream.async_read(buffer, asio::redirect_error(kUseAwaitable, error));
    if (error == websocket::error::message_too_big) co_return "the message is too big";
    if (error) co_return std::string();
    const auto size = static_cast<double>(bytes.size());
    LiveMessage message;
    message.kind = session->stream.got_text() ? LiveMessage::Kind::text : LiveMessage::Kind::binary;
    message.bytes = std::make_shared<const Bytes>(std::move(bytes));
    if (auto taken = publication.message(std::move(message)); !taken) {
      co_return taken.error().message;
    }
    if (limits.publish_rate <= 0) continue;
    // A second's worth may come at once, and for five seconds TCP holds the peer back; but for no
    // second at a time, for then its pings would not be answered.
    const auto now = Clock::now();
    paid = std::max(paid, now - std::chrono::seconds(1)) +
           std::chrono::duration_cast<Clock::duration>(
               std::chrono::duration<double>(size / limits.publish_rate));
    if (paid > now + std::chrono::seconds(5)) {
      co_return fmt::format("more than {} bytes a second came", limits.publish_rate);
    }
    if (paid <= now) continue;
    pause.expires_at(std::min(paid, now + std::chrono::seconds(1)));
    co_await pause.async_wait(asio::redirect_error(kUseAwaitable, error));
  }
}

}  // namespace

Task<void> Wake::sleep() {
  timer_.expires_at(Clock::time_point::max());
  error_code ignored;
  co_await timer_.async_wait(asio::redirect_error(kUseAwaitable, ignored));
}

std::function<void()> Wake::function() {
  return [weak = weak_from_this(), strand = timer_.get_executor()] {
    asio::post(strand, [weak] {
      if (const auto self = weak.lock()) self->timer_.cancel();
    });
  };
}

Task<void> serve_websocket(std::shared_ptr<Transport> transport, std::string received,
                           LiveCall call, std::shared_ptr<Wake> wake, Peer peer, Service& service,
                           const Limits& limits) {
  const bool publishes = call.publication != nullptr;
  const auto session = std::make_shared<Session>(transport, limits, publishes);
  error_code error;
  co_await session->stream.async_accept(asio::buffer(received),
                                        asio::redirect_error(kUseAwaitable, error));
  if (error) co_return;
  service.metrics().count_response(101);
  ++(publishes ? service.metrics().publishers : service.metrics().viewers);
  service.log().write(Log::Level::kInfo, publishes ? "live.publisher" : "live.viewer",
                      {{"peer", peer.address}, {"stream", call.stream}});
  std::string fault;
  if (publishes) {
    fault = co_await read_from_publisher(session, *call.publication, limits);
    call.publication.reset();
  } else {
    asio::co_spawn(transport->executor(), write_messages(session, std::move(call.viewer), wake),
                   asio::detached);
    co_await read_from_viewer(session);
  }
  if (!fault.empty()) {
    service.log().write(
        Log::Level::kWarning, "live.refused",
        {{"peer", peer.address}, {"stream", call.stream}, {"fault", std::string_view(fault)}});
    // A control frame has no room for more than 123 bytes of text.
    const websocket::close_reason reason(websocket::close_code::policy_error,
                                         beast::string_view(fault).substr(0, 123));
    co_await session->stream.async_close(reason, asio::redirect_error(kUseAwaitable, error));
    co_await transport->linger();
  }
  service.log().write(Log::Level::kInfo, publishes ? "live.publisher_ended" : "live.viewer_ended",
                      {{"peer", peer.address}, {"stream", call.stream}});
  transport->close();
  // Who writes sees that the socket is closed.
  if (wake) wake->function()();
}

}  // namespace pointreel
