// Live streams through chains of three servers, as real processes that are killed and come back.

#include <algorithm>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "codec/files/ply.h"
#include "common/net/websocket.h"
#include "tests/e2e/process.h"
#include "tests/e2e/server_address.h"
#include "tests/raw_http_client.h"
#include "tests/temporary_folder.h"
#include "tests/wait.h"

namespace pointreel::e2e::fan_out_test {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using testing::HasSubstr;
using testing::Not;

class FanOutTest : public testing::Test {
 protected:
  void SetUp() override {
    fs::create_directories(folder_ / "frames");
    for (int i = 0; i < 4; ++i) {
      PointCloud cloud;
      for (int j = 0; j < 500; ++j)
        cloud.positions.emplace_back(0.01f * static_cast<float>(j), i, 0);
      ASSERT_TRUE(write_ply(folder_ / "frames" / fmt::format("{}.ply", i), cloud));
    }
    // Ports that were free a moment ago, so that servers can be started again, and in a circle.
    for (std::string& address : addresses_) {
      Background server("pointreel-server", {"serve", "--live", "--listen", "127.0.0.1:0"});
      address = server_address(server);
      ASSERT_FALSE(address.empty());
      server.end(SIGTERM);
    }
  }

  /// Starts the server of this number.
  std::unique_ptr<Background> serve(std::size_t number, const std::vector<std::string>& more = {}) {
    std::vector<std::string> arguments = {"serve", "--live", "--listen", addresses_.at(number)};
    arguments.insert(arguments.end(), more.begin(), more.end());
    Surroundings surroundings;
    surroundings.err = log(number);
    auto server = std::make_unique<Background>("pointreel-server", arguments, surroundings);
    EXPECT_EQ(server_address(*server), addresses_.at(number));
    return server;
  }
  std::string from(std::size_t number) const { return "ws://" + addresses_.at(number) + "/live"; }
  std::string log(std::size_t number) const {
    return (folder_ / fmt::format("log{}", number)).string();
  }
  bool logs(std::size_t number, const std::string& what) const {
    return wait_until([&] {
      std::ifstream in(log(number));
      const std::string text{std::istreambuf_iterator<char>(in), {}};
      return text.find(what) != std::string::npos;
    });
  }
  Background publisher(std::size_t number, const std::vector<std::string>& more = {}) const {
    std::vector<std::string> arguments = {
        "publish", "-i",   (folder_ / "frames").string(), "--fps", "50",
        "--loop",  "--to", from(number) + "/stage"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return {"pointreel-server", arguments};
  }
  std::unique_ptr<WebSocket> viewer(const std::string& url, const std::string& token = "") const {
    WebSocketOptions options;
    options.token = token;
    options.silence_timeout = 20s;
    Result<std::unique_ptr<WebSocket>> socket = fail("");
    wait_until([&] { return (socket = WebSocket::connect(url, options)).has_value(); });
    if (socket) return *std::move(socket);
    ADD_FAILURE() << socket.error().message;
    return nullptr;
  }
  /// Receives that many layers, and then the hello or the end that comes next, if it is wanted.
  static bool receives(WebSocket& socket, int layers) {
    while (layers > 0) {
      const auto message = socket.receive(30s);
      if (!message || !*message) return false;
      if ((*message)->kind == WebSocket::Kind::binary) --layers;
    }
    return true;
  }
  /// Receives until a text of this type comes.
  static bool receives_text(WebSocket& socket, const std::string& type) {
    for (;;) {
      const auto message = socket.receive(30s);
      if (!message || !*message) return false;
      const auto& bytes = (*message)->bytes;
      const std::string text(bytes.begin(), bytes.end());
      if ((*message)->kind == WebSocket::Kind::text && text.find(type) != std::string::npos)
        return true;
    }
  }
  std::string get(std::size_t number, const std::string& target, const std::string& fields = "") {
    return RawHttpClient(port_of(addresses_.at(number))).get(target, fields).body;
  }

  const TemporaryFolder folder_;
  std::vector<std::string> addresses_ = std::vector<std::string>(3);
};

TEST_F(FanOutTest, a_stream_passes_through_three_servers_and_comes_back_after_each_was_killed) {
  std::vector<std::unique_ptr<Background>> servers;
  const auto more = [&](std::size_t number) {
    return number == 0 ? std::vector<std::string>{}
                       : std::vector<std::string>{"--relay-from", from(number - 1)};
  };
  for (std::size_t i = 0; i < 3; ++i) servers.push_back(serve(i, more(i)));
  const Background publishing = publisher(0);
  const auto first = viewer(from(2) + "/stage"), second = viewer(from(2) + "/stage");
  ASSERT_TRUE(first && second);
  ASSERT_TRUE(receives(*first, 10) && receives(*second, 10));
  for (std::size_t i = 0; i < 3; ++i) {
    const std::string metrics = get(i, "/metrics");
    EXPECT_THAT(metrics, HasSubstr(fmt::format("pointreel_live_hops{{stream=\"stage\"}} {}\n", i)));
    EXPECT_THAT(metrics, HasSubstr(fmt::format("pointreel_live_viewers{{stream=\"stage\"}} {}\n",
                                               i < 2 ? 1 : 2)));
    EXPECT_THAT(metrics, HasSubstr("pointreel_live_lag_seconds{stream=\"stage\"}"));
    EXPECT_THAT(metrics, HasSubstr("pointreel_live_lost_frames_total{stream=\"stage\"} 0\n"));
  }
  // Over HTTP, too.
  ASSERT_TRUE(wait_until(
      [&] { return get(2, "/live/stage/reel.json").find("\"session\"") != std::string::npos; }));

  for (const std::size_t killed : {0, 1}) {
    servers[killed]->end(SIGKILL);
    EXPECT_TRUE(receives_text(*first, "\"end\"")) << killed;
    servers[killed] = serve(killed, more(killed));
    EXPECT_TRUE(receives_text(*first, "\"hello\"")) << killed;
    EXPECT_TRUE(receives(*first, 10)) << killed;
  }
  EXPECT_TRUE(receives(*second, 10));
  EXPECT_TRUE(logs(2, "connection is lost"));
  EXPECT_TRUE(logs(2, "connected again"));
  for (const auto& server : servers) EXPECT_EQ(server->end(SIGTERM), 0);
}

TEST_F(FanOutTest, each_side_of_a_relay_has_its_own_token_and_streams_their_own_names) {
  const auto above = serve(0, {"--view-token", "above", "--publish-token", "publish"});
  const auto below = serve(
      1, {"--relay-from", "paris-*=" + from(0), "--relay-token", "above", "--view-token", "below"});
  const auto wrong =
      serve(2, {"--relay-from", "lyon=" + from(0) + "/stage", "--relay-token", "below"});
  const Background publishing = publisher(0, {"--token", "publish"});
  const auto watching = viewer(from(1) + "/paris-stage", "below");
  ASSERT_TRUE(watching);
  EXPECT_TRUE(receives(*watching, 10));
  WebSocketOptions with_upper_token;
  with_upper_token.token = "above";
  const auto refused = WebSocket::connect(from(1) + "/paris-stage", with_upper_token);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::refused);
  EXPECT_TRUE(logs(2, "answers 401: it requires a valid token; give it with --relay-token"));
  EXPECT_EQ(RawHttpClient(port_of(addresses_[2])).get("/live/lyon/reel.json").status, 404);
}

TEST_F(FanOutTest, each_upstream_server_gets_its_own_token_from_a_file) {
  const auto first = serve(0, {"--view-token", "token-one", "--publish-token", "publish"});
  const auto second = serve(1, {"--view-token", "token-two", "--publish-token", "publish"});
  const fs::path tokens = folder_.write(
      "tokens", fmt::format("# upstream servers\n\nws://{}\ttoken-one\nws://{}   token-two\r\n",
                            addresses_[0], addresses_[1]));
  auto below = serve(2, {"--relay-from", "one-*=" + from(0), "--relay-from", "two-*=" + from(1),
                         "--relay-token-file", tokens.string()});
  const Background publishing = publisher(0, {"--token", "publish"});
  const Background publishing_too = publisher(1, {"--token", "publish"});
  for (const char* name : {"/one-stage", "/two-stage"}) {
    const auto watching = viewer(from(2) + name);
    ASSERT_TRUE(watching);
    EXPECT_TRUE(receives(*watching, 10)) << name;
  }
  // With a wrong token for one of them, the other goes on, and no log has a token.
  below->end(SIGTERM);
  folder_.write("tokens", fmt::format("ws://{} token-one", addresses_[0]));
  below = serve(2, {"--relay-from", "one-*=" + from(0), "--relay-from", "two-*=" + from(1),
                    "--relay-token-file", tokens.string(), "--relay-token", "token-three"});
  EXPECT_TRUE(logs(2, "answers 401"));
  const auto watching = viewer(from(2) + "/one-stage");
  ASSERT_TRUE(watching);
  EXPECT_TRUE(receives(*watching, 10));
  for (std::size_t i = 0; i < 3; ++i) {
    std::ifstream in(log(i));
    const std::string text{std::istreambuf_iterator<char>(in), {}};
    EXPECT_THAT(text, Not(HasSubstr("token-"))) << i;
  }
}

TEST_F(FanOutTest, servers_that_relay_in_a_circle_notice_it_and_keep_the_stream) {
  const auto a = serve(0, {"--relay-from", from(2)});
  const auto b = serve(1, {"--relay-from", from(0)});
  const auto c = serve(2, {"--relay-from", from(1)});
  const Background publishing = publisher(0);
  const auto watching = viewer(from(2) + "/stage");
  ASSERT_TRUE(watching);
  EXPECT_TRUE(receives(*watching, 20));
  EXPECT_TRUE(logs(0, "relay in a circle"));
  const auto own = viewer(from(0) + "/stage");
  ASSERT_TRUE(own);
  EXPECT_TRUE(receives(*own, 20));
  EXPECT_THAT(get(2, "/metrics"), HasSubstr("pointreel_live_hops{stream=\"stage\"} 2\n"));
}

}  // namespace
}  // namespace pointreel::e2e::fan_out_test
