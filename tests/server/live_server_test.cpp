// Live streams through the server's sockets, with well-behaved and ill-behaved publishers and
// viewers.

#include <chrono>
#include <csignal>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/net/websocket.h"
#include "server/relay/relay.h"
#include "server/serve/http_server.h"
#include "tests/certificate.h"
#include "tests/live_frames.h"
#include "tests/raw_http_client.h"
#include "tests/temporary_folder.h"
#include "tests/wait.h"

namespace pointreel::live_server_test {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;
using Kind = WebSocket::Kind;

constexpr const char* kUpgrade =
    "Connection: Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Version: 13\r\n"
    "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n";

/// The parameter selects plain connections or TLS.
class LiveServerTest : public testing::TestWithParam<bool> {
 protected:
  LiveServerTest() {
    std::signal(SIGPIPE, SIG_IGN);
    options_.listen.port = 0;
    options_.threads = 2;
    options_.service.log = Log::Level::kOff;
    if (GetParam()) {
      options_.certificate = certificate_.certificate;
      options_.key = certificate_.key;
    }
  }
  void start() {
    auto server = HttpServer::start({}, options_, &relay_);
    ASSERT_TRUE(server) << server.error().message;
    server_ = *std::move(server);
  }
  auto connect(const std::string& target, const std::string& token = "") {
    WebSocketOptions options;
    options.token = token;
    options.ca_file = certificate_.certificate;
    options.silence_timeout = 20s;
    options.connect_timeout = 20s;
    options.confirm = true;
    return WebSocket::connect((GetParam() ? "wss://localhost:" : "ws://127.0.0.1:") +
                                  std::to_string(server_->port()) + target,
                              options);
  }
  std::unique_ptr<WebSocket> connected(const std::string& target, const std::string& token = "") {
    auto socket = connect(target, token);
    if (socket) return *std::move(socket);
    ADD_FAILURE() << target << ": " << socket.error().message;
    return nullptr;
  }
  static bool send(WebSocket& socket, const LiveMessage& message) {
    return socket
        .send(*message.bytes, message.kind == LiveMessage::Kind::text ? Kind::text : Kind::binary)
        .has_value();
  }
  static bool say_hello(WebSocket& socket, std::uint8_t publisher = 1) {
    return send(socket, publisher_message(publisher));
  }
  /// A publisher whose hello the relay has read, so that viewers find the stream "stage".
  std::unique_ptr<WebSocket> stage_publisher() {
    auto publisher = connected("/live/stage?publish");
    if (!publisher || !say_hello(*publisher) ||
        !wait_until([&] { return statistics().publishing; }))
      return nullptr;
    return publisher;
  }
  /// Returns the next message in brief, or the reason why there is none.
  static std::string next(WebSocket& socket) {
    auto message = socket.receive(20s);
    if (!message) return message.error().message;
    if (!*message) return "nothing";
    const auto kind =
        (*message)->kind == Kind::text ? LiveMessage::Kind::text : LiveMessage::Kind::binary;
    return brief({kind, std::make_shared<const Bytes>(std::move((*message)->bytes))});
  }
  StreamStatistics statistics() const {
    const auto all = relay_.statistics();
    return all.empty() ? StreamStatistics() : all.front();
  }

  TemporaryFolder temporary_;
  TestCertificate certificate_{temporary_.path()};
  HttpServerOptions options_;
  Relay relay_;
  std::unique_ptr<HttpServer> server_;
};

INSTANTIATE_TEST_SUITE_P(Transports, LiveServerTest, testing::Values(false, true),
                         [](const auto& tls) { return tls.param ? "tls" : "plain"; });

TEST_P(LiveServerTest, chooses_the_subprotocol_that_browsers_offer) {
  if (GetParam()) GTEST_SKIP() << "the raw client has no TLS";
  start();
  const auto publisher = stage_publisher();
  ASSERT_TRUE(publisher);
  const auto answer = [&](const std::string& fields) {
    return RawHttpClient(server_->port()).get("/live/stage", kUpgrade + fields);
  };
  const auto offered = answer("Sec-WebSocket-Protocol: pointreel, bearer.x\r\n");
  EXPECT_EQ(offered.status, 101);
  EXPECT_EQ(offered.field("sec-websocket-protocol"), "pointreel");
  for (const char* fields : {"", "Sec-WebSocket-Protocol: other\r\n"}) {
    const auto plain = answer(fields);
    EXPECT_EQ(plain.status, 101);
    EXPECT_EQ(plain.field("sec-websocket-protocol"), "");
  }
}

TEST_P(LiveServerTest, forwards_a_stream_from_its_publisher_to_all_viewers) {
  start();
  const auto publisher = stage_publisher();
  ASSERT_TRUE(publisher);
  std::vector<std::unique_ptr<WebSocket>> viewers;
  for (int i = 0; i < 3; ++i) {
    viewers.push_back(connected("/live/stage"));
    ASSERT_TRUE(viewers.back());
    EXPECT_EQ(next(*viewers.back()), "hello");
  }
  for (std::uint32_t frame = 0; frame < 5; ++frame) {
    for (std::uint8_t layer = 0; layer < 3; ++layer) {
      ASSERT_TRUE(send(*publisher, layer_message(frame, layer, 3, frame == 3 ? 300'000 : 100)));
      for (const auto& viewer : viewers) {
        EXPECT_EQ(next(*viewer), std::to_string(frame) + "." + std::to_string(layer));
      }
    }
  }
  publisher->close();
  for (const auto& viewer : viewers) EXPECT_EQ(next(*viewer), "end");
  viewers.clear();
  EXPECT_TRUE(wait_until([&] { return statistics().viewers == 0; }));
  EXPECT_TRUE(wait_until([&] { return server_->connection_count() == 0; }));
}

TEST_P(LiveServerTest, tiny_messages_take_little_memory_while_they_wait) {
  start();
  const auto publisher = stage_publisher();
  ASSERT_TRUE(publisher);
  const auto viewer = relay_.join("stage", [] {});
  ASSERT_TRUE(viewer);
  ASSERT_TRUE(send(*publisher, layer_message(0, 0)));
  std::optional<LiveMessage> message;
  ASSERT_TRUE(wait_until([&] {
    message = (*viewer)->next();
    return message && message->kind == LiveMessage::Kind::binary;
  }));
  EXPECT_LE(message->bytes->capacity(), 2 * message->bytes->size());
}

TEST_P(LiveServerTest, answers_404_for_unknown_streams) {
  start();
  const auto viewer = connect("/live/nobody");
  ASSERT_FALSE(viewer);
  EXPECT_EQ(viewer.error().code, ErrorCode::not_found);
  EXPECT_EQ(connect("/elsewhere").error().code, ErrorCode::not_found);
}

TEST_P(LiveServerTest, grants_viewing_and_publishing_by_token) {
  options_.service.view_token = "look";
  options_.service.publish_token = "show";
  start();
  for (const char* wrong : {"", "look", "shows", "sho", "Show"}) {
    const auto refused = connect("/live/stage?publish", wrong);
    ASSERT_FALSE(refused) << wrong;
    EXPECT_EQ(refused.error().code, ErrorCode::refused) << wrong;
  }
  const auto publisher = connected("/live/stage?publish", "show");
  ASSERT_TRUE(publisher && say_hello(*publisher));
  ASSERT_TRUE(wait_until([&] { return statistics().publishing; }));
  EXPECT_EQ(connect("/live/stage", "show").error().code, ErrorCode::refused)
      << "the two rights are separate";
  EXPECT_EQ(connect("/live/stage").error().code, ErrorCode::refused);
  const auto viewer = connected("/live/stage", "look");
  ASSERT_TRUE(viewer);
  EXPECT_EQ(next(*viewer), "hello");
}

TEST_P(LiveServerTest, tells_a_publisher_why_its_connection_is_closed) {
  start();
  const auto publisher = stage_publisher();
  ASSERT_TRUE(publisher);
  const auto second = connected("/live/stage?publish");
  ASSERT_TRUE(second && say_hello(*second, 2));
  EXPECT_THAT(next(*second), HasSubstr("stage"));
  const Bytes nonsense(100, 7);
  ASSERT_TRUE(publisher->send(nonsense, Kind::binary));
  EXPECT_THAT(next(*publisher), testing::Not(HasSubstr("nothing")));
  EXPECT_TRUE(wait_until([&] { return server_->connection_count() == 0; }));
  EXPECT_FALSE(statistics().publishing);
}

TEST_P(LiveServerTest, confirms_to_a_publisher_what_it_has_accepted) {
  start();
  const auto publisher = stage_publisher();
  ASSERT_TRUE(publisher);
  for (std::uint32_t frame = 0; frame < 50; ++frame) {
    ASSERT_TRUE(send(*publisher, layer_message(frame, 0, 1, frame == 3 ? 300'000 : 100)));
  }
  EXPECT_TRUE(wait_until([&] { return publisher->confirmed() == 51; }));
  EXPECT_EQ(statistics().frames, 50u);
  const auto second = connected("/live/stage?publish");
  ASSERT_TRUE(second);
  say_hello(*second, 2);
  send(*second, layer_message(0, 0));
  EXPECT_THAT(next(*second), HasSubstr("stage"));
  EXPECT_EQ(second->confirmed(), 0u) << "it was refused";
}

TEST_P(LiveServerTest, limits_the_message_size_and_rate_of_publishers) {
  options_.max_message = 100'000;
  options_.publish_rate = 10'000;
  start();
  const auto longest = connected("/live/long?publish");
  ASSERT_TRUE(longest && say_hello(*longest));
  longest->send(*layer_message(0, 0, 3, 100'001).bytes, Kind::binary);
  EXPECT_FALSE(longest->receive(20s));
  const auto fast = connected("/live/fast?publish");
  ASSERT_TRUE(fast && say_hello(*fast));
  fast->send(*layer_message(0, 0, 3, 90'000).bytes, Kind::binary);
  EXPECT_THAT(next(*fast), HasSubstr("more than 10000 bytes a second"));
}

TEST_P(LiveServerTest, limits_the_text_of_publishers) {
  options_.publish_text_rate = 1000;
  start();
  const auto longest = connected("/live/long?publish");
  ASSERT_TRUE(longest && say_hello(*longest));
  const Bytes spaces(kMaxLiveText + 1, ' ');
  longest->send(spaces, Kind::text);
  EXPECT_THAT(next(*longest), HasSubstr("a text message has more than 8192 bytes"));
  const auto talker = connected("/live/talker?publish");
  ASSERT_TRUE(talker && say_hello(*talker));
  const std::string text = R"({"type": "of a later version"})" + std::string(7000, ' ');
  talker->send(Bytes(text.begin(), text.end()), Kind::text);
  EXPECT_THAT(next(*talker), HasSubstr("more than 1000 bytes of text a second"));
}

TEST_P(LiveServerTest, never_lets_a_stalled_viewer_delay_others) {
  options_.stall_timeout = 60s;
  start();
  const auto publisher = stage_publisher();
  ASSERT_TRUE(publisher);
  WebSocketOptions lazy;
  lazy.ca_file = certificate_.certificate;
  lazy.max_waiting = 1;
  lazy.silence_timeout = 60s;
  const auto stalled = WebSocket::connect((GetParam() ? "wss://localhost:" : "ws://127.0.0.1:") +
                                              std::to_string(server_->port()) + "/live/stage",
                                          lazy);
  ASSERT_TRUE(stalled);
  const auto prompt = connected("/live/stage");
  ASSERT_TRUE(prompt);
  EXPECT_EQ(next(*prompt), "hello");
  ASSERT_TRUE(wait_until([&] { return statistics().viewers == 2; }));
  for (std::uint32_t frame = 0; frame < 60; ++frame) {
    ASSERT_TRUE(send(*publisher, layer_message(frame, 0, 1, 500'000)));
    ASSERT_EQ(next(*prompt), std::to_string(frame) + ".0");
  }
  EXPECT_GT(statistics().drops.frames, 0u);
  // Once it reads again, it soon reaches the newest frame.
  std::string last;
  for (int i = 0; i < 60 && last != "59.0"; ++i) last = next(**stalled);
  EXPECT_EQ(last, "59.0");
}

TEST_P(LiveServerTest, drops_peers_that_show_no_sign_of_life) {
  if (GetParam()) GTEST_SKIP() << "the transport makes no difference";
  options_.idle_timeout = 800ms;
  start();
  const auto answering = connected("/live/other?publish");
  ASSERT_TRUE(answering && say_hello(*answering));
  // By the time this client is disconnected, the publisher has been silent for longer.
  RawHttpClient silent(server_->port());
  EXPECT_EQ(silent.get("/live/stage?publish", kUpgrade).status, 101);
  EXPECT_TRUE(wait_until([&] { return server_->connection_count() == 1; }));
  EXPECT_TRUE(send(*answering, layer_message(0, 0)));
  EXPECT_TRUE(
      wait_until([&] { return statistics().frames == 1 || relay_.statistics().size() == 2; }));
  EXPECT_EQ(server_->connection_count(), 1u) << "answering pings keeps it connected";
}

TEST_P(LiveServerTest, accepts_local_publishers_only_without_origin_and_proxy) {
  if (GetParam()) GTEST_SKIP() << "the transport makes no difference";
  start();
  const auto status = [&](const std::string& fields) {
    return RawHttpClient(server_->port()).get("/live/stage?publish", kUpgrade + fields).status;
  };
  EXPECT_EQ(status(""), 101);
  EXPECT_EQ(status("Origin: http://example.org\r\n"), 403) << "a web page must not publish";
  EXPECT_EQ(status("X-Forwarded-For: 192.0.2.7\r\n"), 403) << "it came through a proxy";
  EXPECT_EQ(status("Forwarded: for=192.0.2.7\r\n"), 403);
  EXPECT_EQ(status("Via: 1.1 proxy\r\n"), 403);
}

TEST_P(LiveServerTest, lets_no_page_of_another_origin_connect_unless_it_is_allowed) {
  if (GetParam()) GTEST_SKIP() << "the transport makes no difference";
  options_.service.origins = Origins::parse({"https://allowed.example"}).value();
  start();
  const auto publisher = stage_publisher();
  ASSERT_TRUE(publisher);
  const auto status = [&](const std::string& origin) {
    return RawHttpClient(server_->port())
        .get("/live/stage", kUpgrade + ("Origin: " + origin + "\r\n"))
        .status;
  };
  EXPECT_EQ(status("https://allowed.example"), 101);
  EXPECT_EQ(status("http://localhost"), 101) << "the same origin";
  for (const char* origin : {"http://example.org", "null", "http://localhost:1",
                             "http://localhost.example", "https://allowed.example:444"}) {
    EXPECT_EQ(status(origin), 403) << origin;
  }
}

TEST_P(LiveServerTest, does_not_guess_who_is_local_if_it_listens_on_other_addresses_too) {
  if (GetParam()) GTEST_SKIP() << "the transport makes no difference";
  options_.listen.host = "0.0.0.0";
  start();
  EXPECT_EQ(connect("/live/stage?publish").error().code, ErrorCode::refused);
  options_.service.allow_local_publish = true;
  start();
  EXPECT_TRUE(connect("/live/stage?publish"));
}

TEST_P(LiveServerTest, gives_the_places_of_publishers_that_say_no_hello_to_others) {
  options_.max_hellos_per_address = 2;
  options_.header_timeout = 300ms;
  start();
  const auto one = connected("/live/one?publish"), two = connected("/live/two?publish");
  ASSERT_TRUE(one && two);
  // A text of an unknown type is no hello.
  ASSERT_TRUE(send(*two, text_message(R"({"type": "weather"})")));
  EXPECT_FALSE(one->receive(20s));
  EXPECT_FALSE(two->receive(20s));
  EXPECT_TRUE(wait_until([&] { return connect("/live/two?publish").has_value(); }));
  EXPECT_TRUE(relay_.statistics().empty());
}

TEST_P(LiveServerTest, limits_how_many_publishers_have_not_said_hello) {
  options_.max_hellos_per_address = 2;
  start();
  const auto one = connected("/live/one?publish"), two = connected("/live/two?publish");
  ASSERT_TRUE(one && two);
  EXPECT_EQ(connect("/live/three?publish").error().code, ErrorCode::io);
  ASSERT_TRUE(say_hello(*one));
  EXPECT_TRUE(wait_until([&] { return connect("/live/three?publish").has_value(); }))
      << "whoever has said hello no longer counts";
}

/// The beginning of a binary message of that size, as a client frames it.
std::string begun_message(std::uint32_t size) {
  std::string frame("\x82\xff\0\0\0\0", 6);
  for (int shift = 24; shift >= 0; shift -= 8) frame += static_cast<char>(size >> shift);
  return frame + std::string(4, '\0');
}
/// A text message of 126 bytes to 64 KiB.
std::string framed_text(const LiveMessage& message) {
  const Bytes& text = *message.bytes;
  std::string frame = {'\x81', '\xfe', static_cast<char>(text.size() >> 8),
                       static_cast<char>(text.size() & 0xff)};
  return frame + std::string(4, '\0') + std::string(text.begin(), text.end());
}

TEST_P(LiveServerTest, refuses_unfinished_messages_beyond_the_limit_of_an_address) {
  if (GetParam()) GTEST_SKIP() << "the transport makes no difference";
  options_.max_unfinished_per_address = 3'500'000;
  start();
  const auto metric = [&](const std::string& name) {
    const std::string page = RawHttpClient(server_->port()).get("/metrics").body;
    const auto at = page.find("\n" + name + " ");
    return at == std::string::npos ? -1.0 : std::stod(page.substr(at + name.size() + 2));
  };
  std::vector<std::unique_ptr<RawHttpClient>> clients;
  const std::string million(1'000'000, '\0');
  for (int i = 0; i < 6; ++i) {
    auto client = std::make_unique<RawHttpClient>(server_->port());
    ASSERT_EQ(client->get("/live/s" + std::to_string(i) + "?publish", kUpgrade).status, 101);
    client->send(framed_text(publisher_message(static_cast<std::uint8_t>(i))) +
                 begun_message(2'000'000));
    client->send(million);
    clients.push_back(std::move(client));
    // One after the other: the first three fit and wait for the rest of their messages.
    EXPECT_TRUE(wait_until([&] {
      return metric("pointreel_live_unfinished_bytes") == 1e6 * std::min(i + 1, 3) &&
             metric("pointreel_live_refused_publishers_total{reason=\"bytes\"}") ==
                 std::max(i - 2, 0);
    })) << i
        << ": " << metric("pointreel_live_unfinished_bytes");
  }
  clients.clear();
  EXPECT_TRUE(wait_until([&] { return metric("pointreel_live_unfinished_bytes") == 0.0; }));
}

TEST_P(LiveServerTest, survives_hostile_websocket_frames) {
  if (GetParam()) GTEST_SKIP() << "the transport makes no difference";
  start();
  // Frames without a mask, with reserved bits, with a length beyond all limits, with fragments of a
  // control frame, and noise.
  const std::vector<std::string> frames = {
      std::string("\x82\x05hello", 7),
      std::string("\xf2\x85\0\0\0\0hello", 11),
      std::string("\x82\xff\x7f\xff\xff\xff\xff\xff\xff\xff\0\0\0\0", 14),
      std::string("\x09\x80\0\0\0\0", 6),
      std::string(5000, '\x5a'),
  };
  for (const std::string& frame : frames) {
    RawHttpClient hostile(server_->port());
    ASSERT_EQ(hostile.get("/live/stage?publish", kUpgrade).status, 101);
    hostile.send(frame);
    hostile.end_sending();
  }
  EXPECT_TRUE(wait_until([&] { return server_->connection_count() == 0; }));
  EXPECT_EQ(RawHttpClient(server_->port())
                .get("/live/stage?publish", "Connection: Upgrade\r\nUpgrade: websocket\r\n")
                .status,
            400)
      << "the key and the version are missing";
}

TEST_P(LiveServerTest, stops_at_once_with_open_sessions) {
  start();
  const auto publisher = stage_publisher();
  ASSERT_TRUE(publisher);
  const auto viewer = connected("/live/stage");
  ASSERT_TRUE(viewer);
  EXPECT_EQ(next(*viewer), "hello");
  server_->stop();
  EXPECT_FALSE(publisher->receive(20s));
  EXPECT_FALSE(viewer->receive(20s));
  EXPECT_EQ(statistics().viewers, 0u);
}

}  // namespace
}  // namespace pointreel::live_server_test
