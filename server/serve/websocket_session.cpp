#include "server/serve/websocket_session.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdint>
#include <string_view>
#include <utility>

#include <boost/asio/buffer.hpp>
#include <boost/asio/detached.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/redirect_error.hpp>
#include <boost/beast/websocket/error.hpp>
#include <boost/beast/websocket/stream.hpp>
#include <fmt/format.h>
#include <linux/sockios.h>
#include <netinet/tcp.h>
#include <sys/ioctl.h>
#include <sys/socket.h>

#include "pointreel/bytes.h"
#include "server/relay/rate_limit.h"
#include "server/serve/message_pace.h"
#include "server/serve/transport_stream.h"

namespace pointreel {
namespace {

namespace beast = boost::beast;
namespace websocket = boost::beast::websocket;

/// How many bytes the kernel may hold for a viewer in addition to those in flight. They can no
/// longer be dropped, so slow viewers see them late: at 1 Mbit/s this is an eighth of a second.
constexpr int kUnsentFramesLimit = 16 * 1024;
/// Viewers have nothing to send.
constexpr std::size_t kMaxViewerMessage = 64 * 1024;

using Stream = websocket::stream<TransportStream, false>;  // without compression

/// If a publisher's machine or link disappears, its stream must soon be free for another publisher.
constexpr std::chrono::milliseconds kPublisherSilence{5'000};

/// Shared by the coroutines that read and write, and destroyed with the last of them.
struct Session {
  Session(std::shared_ptr<Transport> on, const Limits& limits, bool publishes)
      : transport(std::move(on)) {
    const auto silence =
        publishes ? std::min(limits.idle_timeout, kPublisherSilence) : limits.idle_timeout;
    stream.set_option(websocket::stream_base::timeout{limits.header_timeout, silence,
                                                      /*keep_alive_pings=*/true});
    stream.auto_fragment(false);
  }

  std::shared_ptr<Transport> transport;
  Stream stream{TransportStream(transport)};
};

/// Sends a viewer what the relay has for it, until the connection ends.
Task<void> write_messages(std::shared_ptr<Session> session, std::unique_ptr<Viewer> viewer,
                          std::shared_ptr<Wake> wake) {
  Socket& socket = session->transport->socket();
  ::setsockopt(socket.native_handle(), IPPROTO_TCP, TCP_NOTSENT_LOWAT, &kUnsentFramesLimit,
               sizeof(kUnsentFramesLimit));
  error_code error;
  while (!error && socket.is_open()) {
    // Asks the relay as late as possible, because the answer depends on what is newest.
    int unsent = 0;
    if (::ioctl(socket.native_handle(), SIOCOUTQNSD, &unsent) == 0 &&
        unsent >= kUnsentFramesLimit) {
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
    std::array<asio::const_buffer, 4> buffers;
    std::ranges::transform(message->pieces(), buffers.begin(), [](ByteView piece) {
      return asio::const_buffer(piece.data(), piece.size());
    });
    co_await session->stream.async_write(buffers, asio::redirect_error(kUseAwaitable, error));
  }
}

/// Reads and ignores what a viewer sends, until the connection ends.
Task<void> read_from_viewer(std::shared_ptr<Session> session) {
  session->stream.read_message_max(kMaxViewerMessage);
  std::array<char, 4096> dropped;
  error_code error;
  while (!error) {
    co_await session->stream.async_read_some(asio::buffer(dropped),
                                             asio::redirect_error(kUseAwaitable, error));
  }
}

/// Why a publisher is disconnected.
struct Fault {
  Metrics::Refused kind = Metrics::Refused::kMessages;
  std::string text;  ///< for the publisher; empty if there is no fault
};

/// A session of a publisher. Shared by the coroutines that read and that watch the time.
struct PublisherSession : Session {
  PublisherSession(std::shared_ptr<Transport> on, const Limits& wanted, PeerQuota::Share share)
      : Session(std::move(on), wanted, true),
        limits(wanted),
        unfinished(std::move(share)),
        pace(wanted.least_rate, Clock::now() + wanted.header_timeout),
        tick(transport->executor()) {}

  Fault too_slow() const {
    if (pace.awaits_hello()) return {Metrics::Refused::kNoHello, "no hello came in time"};
    return {Metrics::Refused::kSlow,
            fmt::format("the message comes at less than {:.0f} bytes a second", limits.least_rate)};
  }

  const Limits& limits;
  PeerQuota::Share unfinished;  ///< bytes of the message under way
  MessagePace pace;
  Timer tick;
  Fault fault;
  bool over = false;
};

/// Ends the session of a publisher from which nothing comes although something is due. One that
/// sends too little is noticed when it sends.
Task<void> watch_pace(std::shared_ptr<PublisherSession> session) {
  error_code ignored;
  while (!session->over) {
    if (Clock::now() >= session->pace.due()) {
      session->fault = session->too_slow();
      session->transport->close();
      break;
    }
    session->tick.expires_after(std::chrono::seconds(1));
    co_await session->tick.async_wait(asio::redirect_error(kUseAwaitable, ignored));
  }
}

/// Reads one message. False if the session must end; its `fault` then says why, if it is a fault.
Task<bool> read_message(std::shared_ptr<PublisherSession> session, Publication& publication,
                        Bytes& bytes) {
  constexpr std::size_t kSpace = 64 * 1024;
  auto& stream = session->stream;
  std::size_t size = 0;
  do {
    // Memory is taken for what has come, not for what is announced.
    if (bytes.size() - size < kSpace / 2) bytes.resize(size + std::max(kSpace, size / 2));
    error_code error;
    const std::size_t more =
        co_await stream.async_read_some(asio::buffer(bytes.data() + size, bytes.size() - size),
                                        asio::redirect_error(kUseAwaitable, error));
    if (error == websocket::error::message_too_big) {
      session->fault.text = "the message is too large";
    }
    if (error == websocket::error::closed &&
        stream.reason().code == websocket::close_code::normal) {
      publication.end();
    }
    if (error) co_return false;
    size += more;
    const auto now = Clock::now();
    session->pace.came(more, now);
    if (stream.got_text() && size > kMaxLiveText) {
      session->fault.text = fmt::format("a text message has more than {} bytes", kMaxLiveText);
      co_return false;
    }
    if (!session->unfinished.grow(more)) {
      session->fault = {Metrics::Refused::kBytes,
                        "too many bytes of messages are not complete; send smaller ones"};
      co_return false;
    }
    if (!stream.is_message_done() && now >= session->pace.due()) {
      session->fault = session->too_slow();
      co_return false;
    }
  } while (!stream.is_message_done());
  bytes.resize(size);
  // Tiny messages that wait, for a disk or a viewer, must not keep the space that was made for
  // more.
  if (bytes.capacity() / 2 > size) bytes.shrink_to_fit();
  session->pace.ended();
  session->unfinished.clear();
  co_return true;
}

/// Passes a publisher's messages to the relay until the session ends.
Task<void> read_from_publisher(std::shared_ptr<PublisherSession> session, LiveCall& call) {
  const Limits& limits = session->limits;
  Publication& publication = *call.publication;
  session->stream.read_message_max(limits.max_message);
  Timer pause(session->transport->executor());
  RateLimit all(limits.publish_rate), text(limits.publish_text_rate);
  while (true) {
    Bytes bytes;
    if (!co_await read_message(session, publication, bytes)) co_return;
    all.add(bytes.size());
    if (session->stream.got_text()) text.add(bytes.size());
    LiveMessage message;
    message.kind = session->stream.got_text() ? LiveMessage::Kind::text : LiveMessage::Kind::binary;
    message.bytes = std::make_shared<const Bytes>(std::move(bytes));
    if (auto taken = publication.message(std::move(message)); !taken) {
      session->fault.text = taken.error().message;
      co_return;
    }
    if (session->pace.awaits_hello() && publication.greeted()) {
      session->pace.greeted();
      call.hello.clear();
    }
    for (const RateLimit* limit : {&all, &text}) {
      if (!limit->is_exceeded()) continue;
      session->fault.text = fmt::format("more than {} bytes{} a second came", limit->rate(),
                                        limit == &text ? " of text" : "");
      co_return;
    }
    // The peer is not read from for up to five seconds, so that TCP holds it back; but not for more
    // than a second at a time, so that its pings are still answered.
    const auto now = Clock::now(), paid = std::max(all.paid(), text.paid());
    if (paid <= now) continue;
    error_code ignored;
    pause.expires_at(std::min(paid, now + std::chrono::seconds(1)));
    co_await pause.async_wait(asio::redirect_error(kUseAwaitable, ignored));
  }
}

/// Serves a publisher until the session ends.
Task<void> serve_publisher(std::shared_ptr<PublisherSession> session, LiveCall& call,
                           const Peer& peer, Service& service) {
  asio::co_spawn(session->transport->executor(), watch_pace(session), asio::detached);
  co_await read_from_publisher(session, call);
  session->over = true;
  session->tick.cancel();
  session->unfinished.clear();
  call.publication.reset();
  const Fault& fault = session->fault;
  if (fault.text.empty()) co_return;
  service.metrics().count_refused(fault.kind);
  service.log().write(
      Log::Level::kWarning, "live.refused",
      {{"peer", peer.address}, {"stream", call.stream}, {"fault", std::string_view(fault.text)}});
  // A control frame has no room for more than 123 bytes of text.
  const websocket::close_reason reason(websocket::close_code::policy_error,
                                       beast::string_view(fault.text).substr(0, 123));
  error_code ignored;
  co_await session->stream.async_close(reason, asio::redirect_error(kUseAwaitable, ignored));
  co_await session->transport->linger();
}

/// serve_websocket, as a coroutine of this file alone: its frame holds types that are.
Task<void> serve_session(std::shared_ptr<Transport> transport, std::string received, LiveCall call,
                         std::shared_ptr<Wake> wake, Peer peer, Service& service,
                         const Limits& limits) {
  const bool publishes = call.publication != nullptr;
  std::shared_ptr<Session> session;
  std::shared_ptr<PublisherSession> publisher;
  if (publishes) {
    session = publisher = std::make_shared<PublisherSession>(
        transport, limits, PeerQuota::Share(service.unfinished(), peer));
  } else {
    session = std::make_shared<Session>(transport, limits, false);
  }
  session->stream.set_option(websocket::stream_base::decorator(
      [protocol = call.protocol](websocket::response_type& response) {
        response.set(beast::http::field::server, "pointreel");
        if (!protocol) return;
        response.set(beast::http::field::sec_websocket_protocol,
                     beast::string_view(kLiveProtocol.data(), kLiveProtocol.size()));
      }));
  error_code error;
  co_await session->stream.async_accept(asio::buffer(received),
                                        asio::redirect_error(kUseAwaitable, error));
  if (error) co_return;
  service.metrics().count_response(101);
  ++(publishes ? service.metrics().publishers : service.metrics().viewers);
  service.log().write(Log::Level::kInfo, publishes ? "live.publisher" : "live.viewer",
                      {{"peer", peer.address}, {"stream", call.stream}});
  if (publishes) {
    co_await serve_publisher(publisher, call, peer, service);
  } else {
    asio::co_spawn(transport->executor(), write_messages(session, std::move(call.viewer), wake),
                   asio::detached);
    co_await read_from_viewer(session);
  }
  service.log().write(Log::Level::kInfo, publishes ? "live.publisher_ended" : "live.viewer_ended",
                      {{"peer", peer.address}, {"stream", call.stream}});
  transport->close();
  // Wakes the coroutine that writes, which then sees that the socket is closed.
  if (wake) wake->function()();
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
  return serve_session(std::move(transport), std::move(received), std::move(call), std::move(wake),
                       std::move(peer), service, limits);
}

}  // namespace pointreel
