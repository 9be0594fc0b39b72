// Streams that a relay takes from another server, which may be hostile.

#include "server/upstream/upstream.h"

#include <array>
#include <atomic>
#include <chrono>
#include <csignal>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <openssl/evp.h>
#include <openssl/sha.h>
#include <sys/socket.h>
#include <unistd.h>

#include "codec/live/live_sound.h"
#include "common/net/server_tokens.h"
#include "server/serve/http_server.h"
#include "tests/live_frames.h"
#include "tests/temporary_folder.h"
#include "tests/wait.h"

namespace pointreel::upstream_test {
namespace {

/// Accepts viewers and sends each of them the same bytes after the answer to the upgrade.
class RawServer {
 public:
  explicit RawServer(std::string bytes) : bytes_(std::move(bytes)) {
    listener_ = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof(address);
    ::bind(listener_, reinterpret_cast<sockaddr*>(&address), size);
    ::listen(listener_, 16);
    ::getsockname(listener_, reinterpret_cast<sockaddr*>(&address), &size);
    port_ = ntohs(address.sin_port);
    thread_ = std::thread([this] {
      for (int client = 0; (client = ::accept(listener_, nullptr, nullptr)) >= 0;) answer(client);
    });
  }
  ~RawServer() {
    ::shutdown(listener_, SHUT_RDWR);
    thread_.join();
    ::close(listener_);
  }
  std::string url(const std::string& path = "/live/stage") const {
    return "ws://127.0.0.1:" + std::to_string(port_) + path;
  }
  int clients() const { return clients_; }

 private:
  void answer(int client) {
    std::string head;
    char c = 0;
    while (!head.ends_with("\r\n\r\n") && ::read(client, &c, 1) == 1) head += c;
    const std::string field = "Sec-WebSocket-Key: ";
    const auto key = head.find(field);
    if (key != std::string::npos) {
      const auto from = key + field.size();
      const std::string text =
          head.substr(from, head.find('\r', from) - from) + "258EAFA5-E914-47DA-95CA-C5AB0DC85B11";
      std::array<unsigned char, SHA_DIGEST_LENGTH> digest{};
      ::SHA1(reinterpret_cast<const unsigned char*>(text.data()), text.size(), digest.data());
      std::array<unsigned char, 32> accept{};
      ::EVP_EncodeBlock(accept.data(), digest.data(), SHA_DIGEST_LENGTH);
      const std::string all =
          "HTTP/1.1 101 Switching Protocols\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
          "Sec-WebSocket-Accept: " +
          std::string(reinterpret_cast<const char*>(accept.data())) + "\r\n\r\n" + bytes_;
      ::send(client, all.data(), all.size(), MSG_NOSIGNAL);
    }
    ++clients_;
    ::shutdown(client, SHUT_WR);
    while (::read(client, &c, 1) == 1) {
    }
    ::close(client);
  }

  const std::string bytes_;
  int listener_ = -1;
  std::uint16_t port_ = 0;
  std::atomic<int> clients_{0};
  std::thread thread_;
};

/// A frame of WebSocket as a server sends it.
std::string frame(const LiveMessage& message) {
  const std::string content(message.bytes->begin(), message.bytes->end());
  std::string frame(1, message.kind == LiveMessage::Kind::text ? '\x81' : '\x82');
  if (content.size() < 126) return frame + static_cast<char>(content.size()) + content;
  frame += '\x7e';
  frame += static_cast<char>(content.size() >> 8);
  frame += static_cast<char>(content.size() & 0xff);
  return frame + content;
}

class UpstreamTest : public testing::Test {
 protected:
  UpstreamTest() { std::signal(SIGPIPE, SIG_IGN); }

  std::unique_ptr<Upstream> follow(const std::string& text) {
    auto options = parse_upstream(text);
    if (!options) {
      ADD_FAILURE() << options.error().message;
      return nullptr;
    }
    options->say = [this](const std::string& line) {
      std::this_thread::sleep_for(saying_takes_);
      const std::lock_guard lock(mutex_);
      said_.push_back(line);
    };
    return Upstream::start(relay_, *options).value();
  }
  std::vector<std::string> said() const {
    const std::lock_guard lock(mutex_);
    return said_;
  }
  bool says(const std::string& what) {
    return wait_until([&] {
      for (const std::string& line : said()) {
        if (line.find(what) != std::string::npos) return true;
      }
      return false;
    });
  }
  StreamStatistics stream(const std::string& name) const {
    for (const StreamStatistics& stream : relay_.statistics()) {
      if (stream.name == name) return stream;
    }
    return {};
  }

  Relay relay_;
  std::chrono::milliseconds saying_takes_{0};
  mutable std::mutex mutex_;
  std::vector<std::string> said_;
};

TEST_F(UpstreamTest, addresses_and_names_are_read_and_mistakes_are_named) {
  const auto all = parse_upstream("wss://host/prefix/live/");
  ASSERT_TRUE(all);
  EXPECT_EQ(all->url, "wss://host/prefix/live");
  EXPECT_EQ(all->stream, "");
  EXPECT_EQ(all->name, "*");
  const auto one = parse_upstream("anna=ws://host:1/live/alice");
  ASSERT_TRUE(one);
  EXPECT_EQ(one->url, "ws://host:1/live/alice");
  EXPECT_EQ(one->stream, "alice");
  EXPECT_EQ(one->name, "anna");
  EXPECT_EQ(parse_upstream("paris-*=ws://host/live")->name, "paris-*");
  for (const char* bad : {"", "host", "http://host/live", "ws://host", "ws://host/live/a?publish",
                          "ws://host/live/a/b", "x=ws://host/live", "**=ws://host/live",
                          "a/*=ws://host/live", "=ws://host/live/a"}) {
    const auto read = parse_upstream(bad);
    ASSERT_FALSE(read) << bad;
    EXPECT_EQ(read.error().code, ErrorCode::argument) << bad;
  }
}

TEST_F(UpstreamTest, a_name_that_gets_too_long_is_reported_and_not_followed) {
  const auto upstream = follow(std::string(60, 'x') + "*=ws://127.0.0.1:1/live/alice");
  EXPECT_TRUE(says("is too long"));
}

TEST_F(UpstreamTest, of_many_lists_only_the_newest_is_acted_on) {
  constexpr int kLists = 500;
  std::string lists;
  for (int i = 0; i < kLists; ++i)
    lists += frame(text_message(write_streams({{"stream" + std::to_string(i)}})));
  const RawServer server(lists);
  // Each list that is acted on gives a line. Meanwhile, others come.
  saying_takes_ = std::chrono::milliseconds(2);
  const auto upstream = follow(std::string(60, 'x') + "*=" + server.url("/live"));
  EXPECT_TRUE(says("stream" + std::to_string(kLists - 1) + " is too long"));
  EXPECT_LT(said().size(), static_cast<std::size_t>(kLists) / 2);
}

TEST(ServerTokens, a_token_is_for_one_host_and_port_with_or_without_tls) {
  const auto tokens = ServerTokens::parse(
      "# ours\n\nwss://Paris.example.org  one\n ws://[::1]:8090\ttwo \r\nws://lyon three");
  ASSERT_TRUE(tokens) << tokens.error().message;
  const auto of = [&](const char* url) {
    const std::string* token = tokens->of(url);
    return token != nullptr ? *token : "none";
  };
  EXPECT_EQ(of("wss://paris.example.org/live"), "one");
  EXPECT_EQ(of("wss://paris.EXAMPLE.org:443/prefix/live/alice"), "one");
  EXPECT_EQ(of("ws://paris.example.org:443/live"), "none");
  EXPECT_EQ(of("wss://paris.example.org:8443/live"), "none");
  EXPECT_EQ(of("wss://paris.example.org.evil/live"), "none");
  EXPECT_EQ(of("ws://[::1]:8090/live"), "two");
  EXPECT_EQ(of("ws://lyon/live"), "three");
  EXPECT_EQ(of("http://lyon/reel"), "three");
  EXPECT_EQ(of("https://paris.example.org/reel"), "one");
  EXPECT_EQ(of("s3://lyon/reel"), "none");
}

TEST(ServerTokens, mistakes_name_their_line_and_no_token) {
  for (const char* bad :
       {"SECRET", "ftp://host SECRET", "wss://host/live SECRET", "SECRET wss://host",
        "wss://host SECRET SECRET", "wss://SECRET@host x",
        "wss://host SECRET\nwss://host:443 SECRET", "wss://host", "wss://host SEC\x01RET"}) {
    const auto read = ServerTokens::parse(bad);
    ASSERT_FALSE(read) << bad;
    EXPECT_EQ(read.error().code, ErrorCode::argument) << bad;
    EXPECT_EQ(read.error().message.find("line "), 0u) << read.error().message;
    EXPECT_EQ(read.error().message.find("SECRET"), std::string::npos) << read.error().message;
  }
  const TemporaryFolder folder;
  EXPECT_EQ(ServerTokens::read(folder / "none").error().message,
            (folder / "none").string() + ": cannot be read");
  const auto file = folder.write("long", std::string(ServerTokens::kMostBytes + 1, '#'));
  EXPECT_NE(ServerTokens::read(file).error().message.find("has more than 65536 bytes"),
            std::string::npos);
  EXPECT_TRUE(ServerTokens::read(folder.write("empty", "")));
}

TEST_F(UpstreamTest, streams_come_and_go_with_those_of_the_other_server) {
  Relay above;
  HttpServerOptions options;
  options.listen.port = 0;
  options.threads = 1;
  options.service.log = Log::Level::kOff;
  options.service.view_token = "secret";
  const auto server = HttpServer::start({}, options, &above).value();
  const std::string url = "ws://127.0.0.1:" + std::to_string(server->port()) + "/live";
  auto parsed = parse_upstream("paris-*=" + url).value();
  parsed.token = "secret";
  const auto upstream = Upstream::start(relay_, parsed).value();
  const auto intruder = follow("wrong-*=" + url);
  EXPECT_TRUE(says("answers 401")) << "without its token";

  auto alice = above.publish("alice").value();
  ASSERT_TRUE(alice->message(publisher_message(1)));
  ASSERT_TRUE(alice->message(layer_message(0, 0)));
  ASSERT_TRUE(wait_until([&] { return stream("paris-alice").frames == 1; }));
  EXPECT_EQ(stream("paris-alice").hops, 1u);
  const auto bob = above.publish("bob").value();
  ASSERT_TRUE(bob->message(publisher_message(2)));
  ASSERT_TRUE(bob->message(layer_message(0, 0)));
  ASSERT_TRUE(wait_until([&] { return stream("paris-bob").frames == 1; }));
  EXPECT_EQ(above.statistics().at(0).viewers, 1u) << "one viewer, however many are below";

  alice.reset();
  ASSERT_TRUE(wait_until([&] { return !stream("paris-alice").publishing; }));
  alice = above.publish("alice").value();
  ASSERT_TRUE(alice->message(publisher_message(1)));
  for (std::uint32_t i = 1; i < 4; ++i) ASSERT_TRUE(alice->message(layer_message(i, 0)));
  ASSERT_TRUE(wait_until([&] { return stream("paris-alice").publishing; }));
  EXPECT_TRUE(stream("wrong-alice").name.empty());
}

TEST_F(UpstreamTest, sound_is_passed_on) {
  Relay above;
  HttpServerOptions options;
  options.listen.port = 0;
  options.threads = 1;
  options.service.log = Log::Level::kOff;
  const auto server = HttpServer::start({}, options, &above).value();
  const auto publisher = above.publish("alice").value();
  ASSERT_TRUE(publisher->message(publisher_message(1)));
  const auto upstream = follow("ws://127.0.0.1:" + std::to_string(server->port()) + "/live/alice");
  ASSERT_TRUE(wait_until([&] { return stream("alice").publishing; }));
  const auto viewer = relay_.join("alice", [] {}, true).value();
  const Bytes packet = {1, 2, 3};
  const LiveSound sound{3, 1'000'000, 960, packet};
  ASSERT_TRUE(publisher->message(
      {LiveMessage::Kind::binary, std::make_shared<const Bytes>(write_live_sound(sound))}));
  EXPECT_TRUE(wait_until([&] {
    const auto message = viewer->next();
    return message && is_live_sound(*message->bytes) &&
           parse_live_sound(*message->bytes).value().number == 3;
  }));
}

TEST_F(UpstreamTest, hostile_bytes_end_the_connection_and_nothing_else) {
  LiveHello hello = plain_hello(7);
  hello.servers = {0xa};
  const std::string good = frame(text_message(write_hello(hello))) + frame(layer_message(0, 0));
  LiveHello circle = hello;
  circle.servers.assign(kMaxLiveServers, 1);
  const std::vector<std::string> hostile = {
      "",
      "no WebSocket",
      std::string("\x82\x7f\x7f\xff\xff\xff\xff\xff\xff\xff", 10),  // 2^63 bytes are announced
      std::string("\x82\x05short", 7),
      frame(text_message("{\"type\":\"hello\"")),
      frame(text_message(std::string(kMaxLiveText + 1, ' '))),
      frame(layer_message(0, 0)),
      frame(text_message(write_hello(circle))),
      good + frame(layer_message(0, 0)),
      good + frame(layer_message(5, 2)),
      good + frame(text_message("[]")),
      good + frame(text_message(write_publisher_hello(hello, {}))),
  };
  for (const std::string& bytes : hostile) {
    SCOPED_TRACE(testing::PrintToString(bytes.substr(0, 100)));
    RawServer server(bytes);
    const auto upstream = follow(server.url());
    ASSERT_TRUE(wait_until([&] { return server.clients() >= 1; }));
    ASSERT_TRUE(wait_until([&] { return !said().empty() && !stream("stage").publishing; }));
    const auto list = follow(server.url("/live"));
    ASSERT_TRUE(wait_until([&] { return server.clients() >= 2; }));
  }
  // The relay still works.
  RawServer server(good);
  const auto upstream = follow(server.url());
  EXPECT_TRUE(wait_until([&] { return server.clients() >= 2; })) << "it connects again";
  const auto publication = relay_.publish("other").value();
  EXPECT_TRUE(publication->message(publisher_message()));
}

TEST_F(UpstreamTest, a_hostile_list_of_streams_is_refused) {
  for (const char* text :
       {R"({"type":"streams","names":["../a"]})", R"({"type":"streams"})", "{"}) {
    RawServer server(frame(text_message(text)));
    const std::size_t before = said().size();
    const auto upstream = follow(server.url("/live"));
    EXPECT_TRUE(wait_until([&] { return said().size() > before; })) << text;
  }
  EXPECT_TRUE(says("not that of a stream"));
  EXPECT_TRUE(relay_.statistics().empty());
}

}  // namespace
}  // namespace pointreel::upstream_test
