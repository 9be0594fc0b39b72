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
#include "server/serve/transport_stream.h"

namespace pointreel {
namespace {

namespace beast = boost::beast;
namespace websocket = boost::beast::websocket;

/// How many bytes the kernel may hold for a viewer in addition to those in flight. They can no
/// longer be dropped, so slow viewers see them late: at 1 Mbit/s this is an eighth of a second.
constexpr int kUnsentLimit = 16 * 1024;
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
    stream.set_option(websocket::stream_base::decorator([](websocket::response_type& response) {
      response.set(beast::http::field::server, "pointreel");
    }));
    stream.auto_fragment(false);
  }

  std::shared_ptr<Transport> transport;
  Stream stream{TransportStream(*transport)};
};

/// Sends a viewer what the relay has for it, until the connection ends.
Task<void> write_messages(std::shared_ptr<Session> session, std::unique_ptr<Viewer> viewer,
                          std::shared_ptr<Wake> wake) {
  Socket& socket = session->transport->socket();
  ::setsockopt(socket.native_handle(), IPPROTO_TCP, TCP_NOTSENT_LOWAT, &kUnsentLimit,
               sizeof(kUnsentLimit));
  error_code error;
  while (!error && socket.is_open()) {
    // Asks the relay as late as possible, because the answer depends on what is newest.
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

/// Holds a publisher to a rate. The bytes of one second may come at once.
class Pace {
 public:
  explicit Pace(double bytes_per_second) : rate_(bytes_per_second) {}

  void add(std::size_t bytes) {
    if (rate_ <= 0) return;
    paid_ = std::max(paid_, Clock::now() - std::chrono::seconds(1)) +
            std::chrono::duration_cast<Clock::duration>(
                std::chrono::duration<double>(static_cast<double>(bytes) / rate_));
  }
  /// The time by which all bytes received so far would have come at the allowed rate.
  Clock::time_point paid() const { return paid_; }
  bool is_exceeded() const { return paid_ > Clock::now() + std::chrono::seconds(5); }
  double rate() const { return rate_; }

 private:
  double rate_;
  Clock::time_point paid_{};
};

/// Passes a publisher's messages to the relay. Returns what was wrong, for the publisher; empty if
/// the publisher has ended the connection.
Task<std::string> read_from_publisher(std::shared_ptr<Session> session, Publication& publication,
                                      const Limits& limits) {
  session->stream.read_message_max(limits.max_message);
  Timer pause(session->transport->executor());
  Pace all(limits.publish_rate), text(limits.publish_text_rate);
  while (true) {
    Bytes bytes;
    auto buffer = asio::dynamic_buffer(bytes, limits.max_message);
    error_code error;
    do {
      co_await session->stream.async_read_some(buffer, 0,
                                               asio::redirect_error(kUseAwaitable, error));
      if (error == websocket::error::message_too_big) co_return "the message is too large";
      if (error == websocket::error::closed &&
          session->stream.reason().code == websocket::close_code::normal) {
        publication.end();
      }
      if (error) co_return std::string();
      if (session->stream.got_text() && bytes.size() > kMaxLiveText) {
        co_return fmt::format("a text message has more than {} bytes", kMaxLiveText);
      }
    } while (!session->stream.is_message_done());
    all.add(bytes.size());
    if (session->stream.got_text()) text.add(bytes.size());
    LiveMessage message;
    message.kind = session->stream.got_text() ? LiveMessage::Kind::text : LiveMessage::Kind::binary;
    message.bytes = std::make_shared<const Bytes>(std::move(bytes));
    if (auto taken = publication.message(std::move(message)); !taken) {
      co_return taken.error().message;
    }
    if (all.is_exceeded()) co_return fmt::format("more than {} bytes a second came", all.rate());
    if (text.is_exceeded()) {
      co_return fmt::format("more than {} bytes of text a second came", text.rate());
    }
    // The peer is not read from for up to five seconds, so that TCP holds it back; but not for more
    // than a second at a time, so that its pings are still answered.
    const auto now = Clock::now(), paid = std::max(all.paid(), text.paid());
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
  // Wakes the coroutine that writes, which then sees that the socket is closed.
  if (wake) wake->function()();
}

}  // namespace pointreel
