#include "tests/link/link_emulator.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <csignal>
#include <cstring>
#include <numeric>
#include <string>
#include <thread>
#include <vector>

#include <arpa/inet.h>
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include "tests/wait.h"

namespace pointreel::link_emulator_test {
namespace {

using namespace std::chrono_literals;
using std::chrono::steady_clock;
using testing::HasSubstr;

sockaddr_in loopback(std::uint16_t port) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  address.sin_port = htons(port);
  return address;
}

/// A server that echoes every byte.
class EchoServer {
 public:
  EchoServer() {
    listener_ = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    sockaddr_in address = loopback(0);
    socklen_t size = sizeof address;
    ::bind(listener_, reinterpret_cast<sockaddr*>(&address), size);
    ::listen(listener_, 16);
    ::getsockname(listener_, reinterpret_cast<sockaddr*>(&address), &size);
    port_ = ntohs(address.sin_port);
    thread_ = std::thread([this] {
      std::vector<std::thread> threads;
      for (int client; (client = ::accept(listener_, nullptr, nullptr)) >= 0;)
        threads.emplace_back([client] {
          std::vector<char> bytes(65536);
          ssize_t n;
          while ((n = ::recv(client, bytes.data(), bytes.size(), 0)) > 0)
            if (::send(client, bytes.data(), static_cast<std::size_t>(n), MSG_NOSIGNAL) < 0) break;
          ::close(client);
        });
      for (std::thread& thread : threads) thread.join();
    });
  }
  ~EchoServer() {
    ::shutdown(listener_, SHUT_RDWR);
    thread_.join();
    ::close(listener_);
  }
  std::string address() const { return fmt::format("127.0.0.1:{}", port_); }

 private:
  int listener_ = -1;
  std::uint16_t port_ = 0;
  std::thread thread_;
};

class Client {
 public:
  explicit Client(std::uint16_t port) : socket_(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
    const sockaddr_in address = loopback(port);
    connected =
        ::connect(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0;
  }
  ~Client() { ::close(socket_); }
  Client(const Client&) = delete;
  Client& operator=(const Client&) = delete;

  void send(const std::string& text) { ::send(socket_, text.data(), text.size(), MSG_NOSIGNAL); }

  /// Receives until `size` bytes have arrived or the connection ends.
  std::string receive(std::size_t size) {
    std::string all(size, '\0');
    std::size_t got = 0;
    while (got < size) {
      const ssize_t n = ::recv(socket_, all.data() + got, size - got, 0);
      if (n <= 0) {
        ended = n == 0;
        broken = n < 0;
        break;
      }
      ++reads;
      got += static_cast<std::size_t>(n);
    }
    all.resize(got);
    return all;
  }
  bool has_something(std::chrono::milliseconds within) {
    pollfd waiting{socket_, POLLIN, 0};
    return ::poll(&waiting, 1, static_cast<int>(within.count())) > 0;
  }

  bool connected = false, ended = false, broken = false;
  int reads = 0;

 private:
  int socket_;
};

class Link : public testing::Test {
 protected:
  Link() {
    auto started = LinkEmulator::start({server_.address()});
    if (!started) throw std::runtime_error(started.error().message);
    link_ = std::move(*started);
  }
  std::string echoed(Client& client, const std::string& text) {
    std::thread sender([&] { client.send(text); });
    std::string back = client.receive(text.size());
    sender.join();
    return back;
  }

  EchoServer server_;
  std::unique_ptr<LinkEmulator> link_;
};

std::string some_text(std::size_t size) {
  std::string text(size, '\0');
  for (std::size_t i = 0; i < size; ++i) text[i] = static_cast<char>(i * 131 >> 3);
  return text;
}

TEST_F(Link, forwards_everything_in_both_directions) {
  Client client(link_->port());
  const std::string text = some_text(3'000'000);
  EXPECT_TRUE(echoed(client, text) == text);
  EXPECT_EQ(link_->statistics().up_bytes, text.size());
  EXPECT_EQ(link_->statistics().down_bytes, text.size());
  EXPECT_EQ(link_->statistics().connections, 1u);
}

TEST_F(Link, is_never_faster_than_its_rate_and_delay) {
  link_->set({.bits_per_second = 8'000'000, .delay = 5ms});
  const std::string text = some_text(100'000);  // 0.1 s
  const auto start = steady_clock::now();
  Client client(link_->port());
  EXPECT_TRUE(echoed(client, text) == text);
  // Connecting takes another round trip, and so do the bytes.
  EXPECT_GE(steady_clock::now() - start, 100ms + 20ms);
}

TEST_F(Link, limits_the_rate_of_all_connections_together_or_of_each) {
  const std::string text = some_text(50'000);
  for (const bool each : {false, true}) {
    link_->set({.bits_per_second = 8'000'000, .rate_each = each});
    const auto start = steady_clock::now();
    std::vector<std::thread> threads;
    for (int i = 0; i < 4; ++i)
      threads.emplace_back([&] {
        Client client(link_->port());
        EXPECT_TRUE(echoed(client, text) == text);
      });
    for (std::thread& thread : threads) thread.join();
    EXPECT_GE(steady_clock::now() - start, each ? 50ms : 195ms);
  }
}

TEST_F(Link, holds_bytes_during_a_cut_and_delivers_them_afterwards) {
  Client client(link_->port());
  EXPECT_EQ(echoed(client, "before"), "before");
  link_->set({.cut = true});
  Client later(link_->port());
  client.send("while");
  later.send("later");
  EXPECT_FALSE(client.has_something(50ms));
  EXPECT_FALSE(later.has_something(1ms));
  link_->set({});
  EXPECT_EQ(client.receive(5), "while");
  EXPECT_EQ(later.receive(5), "later");
}

TEST_F(Link, resets_connections_and_accepts_new_ones) {
  Client client(link_->port());
  EXPECT_EQ(echoed(client, "before"), "before");
  link_->reset_connections();
  EXPECT_EQ(client.receive(1), "");
  EXPECT_TRUE(client.broken);
  Client next(link_->port());
  EXPECT_EQ(echoed(next, "after"), "after");
}

TEST_F(Link, ends_connections_whose_sockets_a_forked_process_still_has) {
  Client client(link_->port());
  EXPECT_EQ(echoed(client, "before"), "before");
  const pid_t copy = ::fork();
  if (copy == 0) {
    ::alarm(60);  // if the test cannot end it
    ::pause();
    ::_exit(0);
  }
  link_->reset_connections();
  EXPECT_TRUE(wait_until([&] { return link_->statistics().open == 0; }));
  client.send("to nobody");  // must not wake the link for a connection that is gone
  Client next(link_->port());
  EXPECT_EQ(echoed(next, "after"), "after");
  ::kill(copy, SIGKILL);
  ::waitpid(copy, nullptr, 0);
}

TEST_F(Link, drops_connections_silently) {
  Client client(link_->port());
  EXPECT_EQ(echoed(client, "before"), "before");
  link_->forget_connections();
  client.send("gone");
  EXPECT_FALSE(client.has_something(50ms));
  Client next(link_->port());
  EXPECT_EQ(echoed(next, "after"), "after");
}

TEST_F(Link, delivers_single_bytes) {
  link_->set({.split = 1});
  Client client(link_->port());
  const std::string text = some_text(2000);
  EXPECT_TRUE(echoed(client, text) == text);
}

TEST_F(Link, flips_bits_on_the_way_from_the_target) {
  link_->set({.corrupt_every = 1000});
  Client client(link_->port());
  const std::string text = some_text(100'000);
  const std::string back = echoed(client, text);
  ASSERT_EQ(back.size(), text.size());
  std::size_t differ = 0;
  for (std::size_t i = 0; i < text.size(); ++i) differ += back[i] != text[i];
  EXPECT_EQ(differ, link_->statistics().flipped_bits);
  EXPECT_GT(differ, 20u);
  EXPECT_LT(differ, 500u);
}

TEST_F(Link, ends_or_resets_connections_after_a_number_of_bytes) {
  link_->set({.truncate_after = 1234});
  Client cut(link_->port());
  EXPECT_EQ(echoed(cut, some_text(5000)), some_text(5000).substr(0, 1234));
  EXPECT_TRUE(cut.ended || cut.broken);
  link_->set({.reset_after = 100});
  Client reset(link_->port());
  EXPECT_LE(echoed(reset, some_text(5000)).size(), 100u);
  EXPECT_TRUE(reset.broken);
}

TEST_F(Link, refuses_connections_if_its_target_does) {
  std::string nobody;
  {
    nobody = EchoServer().address();
  }
  ASSERT_TRUE(link_->set_target(nobody));
  Client client(link_->port());
  client.send("hello");
  EXPECT_EQ(client.receive(1), "");
  ASSERT_TRUE(link_->set_target(server_.address()));
  Client next(link_->port());
  EXPECT_EQ(echoed(next, "hello"), "hello");
}

TEST_F(Link, follows_a_script) {
  ASSERT_TRUE(link_->run({{0ms, "rate 5M"}, {0ms, "delay 2.5"}, {1ms, "split 7"}, {2ms, "cut"}}));
  EXPECT_TRUE(wait_until([&] { return link_->conditions().cut; }));
  const LinkConditions conditions = link_->conditions();
  EXPECT_EQ(conditions.bits_per_second, 5'000'000u);
  EXPECT_EQ(conditions.delay, 2500us);
  EXPECT_EQ(conditions.split, 7u);
  EXPECT_FALSE(link_->run({{0ms, "explode"}}));
}

TEST(LinkScript, is_parsed_line_by_line) {
  const auto script = parse_link_script("# comment\n\n0 rate 100M\n 5.5  rate 5M # slower\n7 cut");
  ASSERT_TRUE(script) << script.error().message;
  ASSERT_EQ(script->size(), 3u);
  EXPECT_EQ((*script)[1].at, 5500ms);
  EXPECT_EQ((*script)[1].what, "rate 5M");
  EXPECT_EQ((*script)[2].what, "cut");
}

TEST(LinkScript, names_the_line_of_an_error) {
  EXPECT_THAT(parse_link_script("0 cut\nsoon cut").error().message, HasSubstr("line 2"));
  EXPECT_THAT(parse_link_script("0 explode").error().message, HasSubstr("\"explode\""));
  EXPECT_THAT(parse_link_script("0 rate").error().message, HasSubstr("needs a number"));
  EXPECT_THAT(parse_link_script("0 rate -5").error().message, HasSubstr("needs a number"));
  EXPECT_THAT(parse_link_script("0 cut 5").error().message, HasSubstr("takes no number"));
  EXPECT_THAT(parse_link_script("0 rate 5 6").error().message, HasSubstr("more than"));
}

}  // namespace
}  // namespace pointreel::link_emulator_test
