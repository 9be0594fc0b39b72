// The WebSocket client against peers that behave and peers that do not.

#include "common/net/websocket.h"

#include <chrono>
#include <functional>
#include <future>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/http/message.hpp>
#include <boost/beast/http/read.hpp>
#include <boost/beast/http/string_body.hpp>
#include <boost/beast/http/write.hpp>
#include <boost/beast/websocket/stream.hpp>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/view.h"
#include "tests/wait.h"

namespace pointreel::websocket_test {
namespace {

using namespace std::chrono_literals;
using boost::asio::ip::tcp;
using testing::HasSubstr;
using testing::StartsWith;
namespace beast = boost::beast;
namespace http = boost::beast::http;
using PeerStream = beast::websocket::stream<tcp::socket>;

constexpr auto kLong = 20s;

/// Serves one connection in a thread: reads the upgrade request, then runs the script.
class Peer {
 public:
  using Script =
      std::function<void(tcp::socket& socket, http::request<http::string_body>& upgrade)>;

  explicit Peer(Script script)
      : acceptor_(context_, {boost::asio::ip::address_v4::loopback(), 0}),
        thread_([this, script = std::move(script)] {
          boost::system::error_code error;
          tcp::socket socket = acceptor_.accept(error);
          if (error) return;
          try {
            beast::flat_buffer buffer;
            http::request<http::string_body> upgrade;
            http::read(socket, buffer, upgrade);
            script(socket, upgrade);
          } catch (const boost::system::system_error&) {
          }
        }) {}
  ~Peer() {
    // If no client ever connected, this connection ends the wait.
    boost::system::error_code ignored;
    tcp::socket(context_).connect(acceptor_.local_endpoint(), ignored);
    thread_.join();
  }

  std::string url(const std::string& path = "/live/stage") const {
    return "ws://127.0.0.1:" + std::to_string(acceptor_.local_endpoint().port()) + path;
  }

 private:
  boost::asio::io_context context_;
  tcp::acceptor acceptor_;
  std::thread thread_;
};

/// A peer that accepts the upgrade and then runs `script`.
Peer::Script upgraded(std::function<void(PeerStream&)> script) {
  return [script](tcp::socket& socket, http::request<http::string_body>& upgrade) {
    PeerStream stream(std::move(socket));
    stream.accept(upgrade);
    script(stream);
  };
}

void read_until_closed(PeerStream& stream) {
  for (;;) {
    beast::flat_buffer buffer;
    stream.read(buffer);
  }
}

WebSocketMessage must_receive(WebSocket& socket) {
  const auto message = socket.receive(kLong);
  if (!message || !*message) {
    ADD_FAILURE() << (message ? "nothing came" : message.error().message);
    return {};
  }
  return **message;
}

std::string how_it_ended(WebSocket& socket) {
  for (;;) {
    const auto message = socket.receive(kLong);
    if (!message) return message.error().message;
    if (!*message) return "it did not";
  }
}

TEST(WebSocket, messages_travel_both_ways_and_keep_their_kind_and_boundaries) {
  const Peer peer(upgraded([](PeerStream& stream) {
    for (;;) {
      beast::flat_buffer buffer;
      stream.read(buffer);
      stream.binary(stream.got_binary());
      stream.write(buffer.data());
    }
  }));
  const auto socket = WebSocket::connect(peer.url());
  ASSERT_TRUE(socket) << socket.error().message;
  Bytes large(3'000'000);
  for (std::size_t i = 0; i < large.size(); ++i) large[i] = static_cast<std::uint8_t>(i * i >> 7);
  ASSERT_TRUE((*socket)->send(view("hello"), WebSocket::Kind::text));
  ASSERT_TRUE((*socket)->send(large, WebSocket::Kind::binary));
  ASSERT_TRUE((*socket)->send(ByteView{}, WebSocket::Kind::binary));
  const WebSocketMessage text = must_receive(**socket);
  EXPECT_EQ(text.kind, WebSocket::Kind::text);
  EXPECT_EQ(std::string(text.bytes.begin(), text.bytes.end()), "hello");
  const WebSocketMessage binary = must_receive(**socket);
  EXPECT_EQ(binary.kind, WebSocket::Kind::binary);
  EXPECT_TRUE(binary.bytes == large);
  EXPECT_TRUE(must_receive(**socket).bytes.empty());
}

TEST(WebSocket, the_server_receives_the_token_and_the_path) {
  std::promise<std::string> told;
  const Peer peer([&](tcp::socket&, http::request<http::string_body>& upgrade) {
    told.set_value(std::string(upgrade.target()) + " " +
                   std::string(upgrade[http::field::authorization]));
  });
  WebSocketOptions options;
  options.token = "secret";
  EXPECT_FALSE(WebSocket::connect(peer.url("/live/stage?publish"), options));
  EXPECT_EQ(told.get_future().get(), "/live/stage?publish Bearer secret");
}

TEST(WebSocket, the_status_of_a_refusing_server_is_reported) {
  const Peer peer([](tcp::socket& socket, http::request<http::string_body>&) {
    http::response<http::string_body> response(http::status::not_found, 11);
    response.body() = "nobody publishes stage\nsecond line";
    response.prepare_payload();
    http::write(socket, response);
  });
  const auto socket = WebSocket::connect(peer.url());
  ASSERT_FALSE(socket);
  EXPECT_EQ(socket.error().code, ErrorCode::not_found);
  EXPECT_THAT(socket.error().message, StartsWith("127.0.0.1:"));
  EXPECT_THAT(socket.error().message, HasSubstr("answers 404: nobody publishes stage"));
  EXPECT_THAT(socket.error().message, testing::Not(HasSubstr("second line")));
}

TEST(WebSocket, a_server_that_does_not_answer_may_use_tls) {
  for (const bool resets : {false, true}) {
    const Peer peer([resets](tcp::socket& socket, http::request<http::string_body>&) {
      socket.set_option(tcp::socket::linger(resets, 0));
    });
    const auto socket = WebSocket::connect(peer.url());
    ASSERT_FALSE(socket);
    EXPECT_THAT(socket.error().message, HasSubstr("if the server uses TLS, use wss://"));
  }
}

TEST(WebSocket, connecting_to_a_closed_port_fails_at_once) {
  boost::asio::io_context context;
  tcp::acceptor acceptor(context, {boost::asio::ip::address_v4::loopback(), 0});
  const std::string url =
      "ws://127.0.0.1:" + std::to_string(acceptor.local_endpoint().port()) + "/live/stage";
  acceptor.close();
  const auto socket = WebSocket::connect(url);
  ASSERT_FALSE(socket);
  EXPECT_EQ(socket.error().code, ErrorCode::io);
  EXPECT_THAT(socket.error().message, HasSubstr("nothing answers there"));
}

TEST(WebSocket, the_reason_of_a_server_for_closing_is_reported) {
  const Peer peer(upgraded([](PeerStream& stream) {
    stream.write(boost::asio::buffer("last", 4));
    stream.close({beast::websocket::close_code::policy_error, "somebody else publishes stage"});
  }));
  const auto socket = WebSocket::connect(peer.url());
  ASSERT_TRUE(socket);
  EXPECT_EQ(must_receive(**socket).bytes.size(), 4u) << "the message before it is not lost";
  EXPECT_THAT(how_it_ended(**socket), HasSubstr("somebody else publishes stage"));
  EXPECT_FALSE((*socket)->send(view("more"), WebSocket::Kind::text));
}

/// Sends these bytes behind the upgrade and leaves the connection open until the end of the test.
class RawPeer {
 public:
  explicit RawPeer(const std::string& bytes)
      : peer_(upgraded([this, bytes](PeerStream& stream) {
          boost::asio::write(stream.next_layer(), boost::asio::buffer(bytes));
          over_.get_future().wait();
        })) {}
  ~RawPeer() { over_.set_value(); }

  std::string how_a_client_ended() const {
    WebSocketOptions options;
    options.silence_timeout = 200ms;
    const auto socket = WebSocket::connect(peer_.url(), options);
    return socket ? how_it_ended(**socket) : socket.error().message;
  }

 private:
  std::promise<void> over_;
  const Peer peer_;
};

TEST(WebSocket, the_reason_of_a_server_that_does_not_end_the_connection_is_reported) {
  EXPECT_THAT(RawPeer("\x88\x06\x03\xf0"
                      "full")
                  .how_a_client_ended(),
              HasSubstr(": full"));
}

TEST(WebSocket, broken_frames_are_named_as_such) {
  const std::string reserved_bit("\xc1\x01x"),
      endless("\x82\x7f\x7f\xff\xff\xff\xff\xff\xff\xff", 10);
  for (const std::string& bytes : {reserved_bit, endless})
    EXPECT_THAT(RawPeer(bytes).how_a_client_ended(), HasSubstr("broke the WebSocket protocol"));
}

TEST(WebSocket, a_lost_connection_ends_waits_with_an_error) {
  const Peer peer(upgraded([](PeerStream& stream) { stream.next_layer().close(); }));
  const auto socket = WebSocket::connect(peer.url());
  ASSERT_TRUE(socket);
  EXPECT_THAT(how_it_ended(**socket), HasSubstr("the connection is lost"));
}

TEST(WebSocket, a_silent_peer_counts_as_lost) {
  std::promise<void> over;
  const Peer peer(upgraded([&](PeerStream&) { over.get_future().wait(); }));
  WebSocketOptions options;
  options.silence_timeout = 200ms;
  const auto socket = WebSocket::connect(peer.url(), options);
  ASSERT_TRUE(socket);
  EXPECT_THAT(how_it_ended(**socket), HasSubstr("fallen silent"));
  over.set_value();
}

TEST(WebSocket, a_peer_that_only_answers_pings_is_not_lost) {
  const Peer peer(upgraded(read_until_closed));
  WebSocketOptions options;
  options.silence_timeout = 600ms;
  const auto socket = WebSocket::connect(peer.url(), options);
  ASSERT_TRUE(socket);
  const auto message = (*socket)->receive(800ms);
  ASSERT_TRUE(message) << message.error().message;
  EXPECT_FALSE(*message);
}

TEST(WebSocket, an_oversized_message_ends_the_connection) {
  const Peer peer(upgraded([](PeerStream& stream) {
    stream.binary(true);
    stream.write(boost::asio::buffer(std::string(5000, 'x')));
    read_until_closed(stream);
  }));
  WebSocketOptions options;
  options.max_message = 4096;
  const auto socket = WebSocket::connect(peer.url(), options);
  ASSERT_TRUE(socket);
  EXPECT_THAT(how_it_ended(**socket), HasSubstr("more than 4096 bytes"));
}

TEST(WebSocket, waiting_messages_are_bounded_and_none_is_lost) {
  const Peer peer(upgraded([](PeerStream& stream) {
    stream.binary(true);
    for (int i = 0; i < 300; ++i) {
      stream.write(boost::asio::buffer(std::string(100'000, static_cast<char>(i))));
    }
    read_until_closed(stream);
  }));
  WebSocketOptions options;
  options.max_waiting = 300'000;
  options.silence_timeout = 20s;
  const auto socket = WebSocket::connect(peer.url(), options);
  ASSERT_TRUE(socket);
  for (int i = 0; i < 300; ++i) {
    const WebSocketMessage message = must_receive(**socket);
    ASSERT_EQ(message.bytes.size(), 100'000u);
    ASSERT_EQ(static_cast<char>(message.bytes[0]), static_cast<char>(i));
  }
}

TEST(WebSocket, closing_ends_a_wait_in_another_thread) {
  const Peer peer(upgraded(read_until_closed));
  const auto socket = WebSocket::connect(peer.url());
  ASSERT_TRUE(socket);
  auto waiting = std::async(std::launch::async, [&] { return how_it_ended(**socket); });
  (*socket)->close();
  EXPECT_THAT(waiting.get(), HasSubstr("closed"));
  EXPECT_FALSE((*socket)->send(view("more"), WebSocket::Kind::text));
}

TEST(WebSocket, closing_ends_although_the_peer_never_answers) {
  std::vector<std::unique_ptr<Peer>> peers;
  std::vector<std::unique_ptr<WebSocket>> sockets;
  WebSocketOptions options;
  options.silence_timeout = 600ms;  // checked after half of it, while the handshake is under way
  for (int i = 0; i < 16; ++i) {
    // Takes all bytes, the close frame included, without answering, until the client goes.
    peers.push_back(std::make_unique<Peer>(upgraded([](PeerStream& stream) {
      char bytes[64];
      for (;;) stream.next_layer().read_some(boost::asio::buffer(bytes));
    })));
    auto socket = WebSocket::connect(peers.back()->url(), options);
    ASSERT_TRUE(socket) << socket.error().message;
    sockets.push_back(std::move(*socket));
  }
  for (const auto& socket : sockets) socket->close();
  for (const auto& socket : sockets) {
    const auto message = socket->receive(kLong);
    ASSERT_FALSE(message);
    EXPECT_EQ(message.error().code, ErrorCode::cancelled) << message.error().message;
  }
}

TEST(WebSocket, closing_ends_although_a_ping_waits_for_its_answer) {
  std::promise<void> closing;
  const Peer peer(upgraded([&](PeerStream& stream) {
    stream.ping({});
    closing.get_future().wait();
    std::this_thread::sleep_for(50ms);  // let the closing handshake queue behind the message
    // Takes all bytes without answering.
    std::vector<char> bytes(1 << 20);
    for (;;) stream.next_layer().read_some(boost::asio::buffer(bytes));
  }));
  const auto socket = WebSocket::connect(peer.url());
  ASSERT_TRUE(socket) << socket.error().message;
  // While a message is being written, neither the ping can be answered nor the handshake begin.
  const Bytes much(32 << 20);
  auto sending = std::async(std::launch::async,
                            [&] { return (*socket)->send(much, WebSocket::Kind::binary); });
  EXPECT_FALSE(*(*socket)->receive(100ms));
  (*socket)->close();
  closing.set_value();
  const auto message = (*socket)->receive(kLong);
  ASSERT_FALSE(message) << "the connection did not end";
  EXPECT_EQ(message.error().code, ErrorCode::cancelled) << message.error().message;
  sending.wait();
}

TEST(WebSocket, empty_messages_that_wait_are_bounded_as_others_are) {
  constexpr std::size_t kMessages = 10'000;
  const Peer peer(upgraded([](PeerStream& stream) {
    for (std::size_t i = 0; i < kMessages; ++i) stream.write(boost::asio::const_buffer());
    read_until_closed(stream);
  }));
  WebSocketOptions options;
  options.max_waiting = 100'000;
  constexpr std::size_t kMost = 100'000 / sizeof(WebSocketMessage);
  const auto socket = WebSocket::connect(peer.url(), options);
  ASSERT_TRUE(socket) << socket.error().message;
  ASSERT_TRUE(wait_until([&] { return (*socket)->waiting() > 50; }));
  EXPECT_FALSE(wait_until([&] { return (*socket)->waiting() > kMost; }, kMoment));
  for (std::size_t i = 0; i < kMessages; ++i) {
    EXPECT_TRUE(must_receive(**socket).bytes.empty());
    ASSERT_LE((*socket)->waiting(), kMost);
  }
}

TEST(WebSocket, connecting_can_be_stopped) {
  std::promise<void> over;
  std::stop_source stop;
  // This peer never answers the upgrade request.
  const Peer peer([&](tcp::socket&, http::request<http::string_body>&) {
    stop.request_stop();
    over.get_future().wait();
  });
  WebSocketOptions options;
  options.connect_timeout = kLong;
  options.stop = stop.get_token();
  const auto begun = std::chrono::steady_clock::now();
  EXPECT_FALSE(WebSocket::connect(peer.url(), options));
  EXPECT_LT(std::chrono::steady_clock::now() - begun, kLong / 2);
  over.set_value();
}

TEST(WebSocket, connecting_gives_up_after_its_timeout) {
  std::promise<void> over;
  const Peer peer(
      [&](tcp::socket&, http::request<http::string_body>&) { over.get_future().wait(); });
  WebSocketOptions options;
  options.connect_timeout = 200ms;
  const auto socket = WebSocket::connect(peer.url(), options);
  ASSERT_FALSE(socket);
  EXPECT_EQ(socket.error().code, ErrorCode::io);
  over.set_value();
}

TEST(WebSocketUrl, is_split_into_its_parts) {
  const auto url = [](const char* text) {
    const auto parsed = parse_websocket_url(text);
    if (!parsed) return parsed.error().message;
    return (parsed->tls() ? "tls " : "") + parsed->place() + " " + parsed->target;
  };
  EXPECT_EQ(url("ws://host:8090/live/stage"), "host:8090 /live/stage");
  EXPECT_EQ(url("wss://host/live/stage?publish#there"), "tls host:443 /live/stage?publish");
  EXPECT_EQ(url("ws://[::1]:81"), "[::1]:81 /");
  EXPECT_EQ(url("ws://host?publish"), "host:80 /?publish");
  for (const char* wrong :
       {"http://host/", "ws://", "ws://:80/", "ws://host:0/", "ws://host:65536/", "ws://host:8o/",
        "ws://[::1/", "ws://a b/", "ws://host/a\r\nX: y", "ws://me:secret@host/", "ws://[::1]x/"}) {
    EXPECT_FALSE(parse_websocket_url(wrong)) << wrong;
  }
}

}  // namespace
}  // namespace pointreel::websocket_test
