// Packages behind nginx, configured as in server/nginx/*.conf, play as they do from their folder.

#include "tests/nginx/nginx.h"

#include <algorithm>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <future>
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
#include "tests/e2e/play.h"
#include "tests/e2e/process.h"
#include "tests/e2e/server_address.h"
#include "tests/raw_http_client.h"
#include "tests/read_file.h"
#include "tests/temporary_folder.h"
#include "tests/wait.h"

namespace pointreel::e2e::nginx_test {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using testing::HasSubstr;
using Answer = RawHttpClient::Answer;

/// The value of the metric `name` in a page of metrics.
double metric(const std::string& page, const std::string& name) {
  const auto at = page.find("\n" + name + " ");
  return at == std::string::npos ? -1.0 : std::stod(page.substr(at + name.size() + 2));
}

class NginxTest : public testing::Test {
 protected:
  void SetUp() override {
    if (!Nginx::installed()) GTEST_SKIP() << "nginx is not installed: apt-get install nginx";
    fs::create_directories(folder_ / "in");
    fs::create_directories(folder_ / "reels");
    for (int frame = 0; frame < 3; ++frame) {
      PointCloud cloud;
      for (int i = 0; i < 60'000; ++i) {
        cloud.positions.push_back(
            {0.001f * static_cast<float>(i % 245), 0.001f * static_cast<float>(i / 245),
             0.05f * static_cast<float>(frame) + 0.0001f * static_cast<float>((i * 7919) % 977)});
        cloud.colors.push_back(glm::u16vec3(i % 65536, 65535 - i % 65536, 20'000 * frame));
      }
      ASSERT_TRUE(write_ply(folder_ / fmt::format("in/{}.ply", frame), cloud));
    }
    const Outcome packed =
        run("pointreel-server", {"pack", "-i", (folder_ / "in").string(), "-o",
                                 (folder_ / "reels" / "wall").string(), "--depth", "10"});
    ASSERT_EQ(packed.exit_code, 0) << packed.err;
    for (const auto& entry : fs::directory_iterator(folder_ / "reels" / "wall")) {
      const std::string name = entry.path().filename().string();
      if (name.find(".base.") != std::string::npos) base_ = name;
    }
    ASSERT_FALSE(base_.empty());
  }

  std::string picture(const std::string& source, const std::string& name) {
    const std::string file = (folder_ / name).string();
    const Outcome played = run("pointreel", {"play", source, "--mode", "point", "--offscreen",
                                             "200x150", "--at", "0.05", "--screenshot", file});
    EXPECT_EQ(played.exit_code, 0) << source << ": " << played.err;
    return read_file(file);
  }

  /// A cache in front of the server on this port, as live.conf configures it.
  Result<std::unique_ptr<Nginx>> cache_of(std::uint16_t port) {
    return Nginx::start(folder_ / "nginx", [&](std::uint16_t own) {
      return nginx_configuration("live.conf",
                                 {{"listen 80;", fmt::format("listen 127.0.0.1:{};", own)},
                                  {"127.0.0.1:8090", fmt::format("127.0.0.1:{}", port)},
                                  {"/var/cache/nginx-pointreel", (folder_ / "cache").string()}});
    });
  }

  TemporaryFolder folder_;
  std::string base_;
};

TEST_F(NginxTest, packages_play_from_plain_nginx_exactly_as_from_their_folder) {
  const auto nginx = Nginx::start(folder_ / "nginx", [&](std::uint16_t port) {
    return nginx_configuration("packages.conf",
                               {{"listen 80;", fmt::format("listen 127.0.0.1:{};", port)},
                                {"/srv/pointreel", (folder_ / "reels").string()}});
  });
  ASSERT_TRUE(nginx) << nginx.error().message;
  const std::string url = fmt::format("http://127.0.0.1:{}/wall/reel.json", (*nginx)->port());
  const std::string there = picture(url, "there.png");
  EXPECT_FALSE(there.empty());
  EXPECT_EQ(there, picture((folder_ / "reels" / "wall").string(), "here.png"));

  RawHttpClient client((*nginx)->port());
  const Answer part = client.get("/wall/" + base_, "Range: bytes=10-99\r\n");
  EXPECT_EQ(part.status, 206);
  EXPECT_EQ(part.body, read_file(folder_ / "reels" / "wall" / base_).substr(10, 90));
  EXPECT_EQ(part.field("cache-control"), "public, max-age=31536000, immutable");
  EXPECT_EQ(part.field("access-control-allow-origin"), "*");
  EXPECT_THAT(part.field("access-control-expose-headers"), HasSubstr("Content-Range"));
  const Answer manifest = client.get("/wall/reel.json");
  EXPECT_EQ(manifest.field("cache-control"), "no-cache");
  EXPECT_EQ(manifest.field("content-type"), "application/json");
  EXPECT_EQ(
      client.get("/wall/reel.json", "If-None-Match: " + manifest.field("etag") + "\r\n").status,
      304);
  EXPECT_EQ(client.request("OPTIONS", "/wall/" + base_, "Origin: http://example.org\r\n").status,
            204);
  EXPECT_EQ(client.request("DELETE", "/wall/" + base_).status, 403);
  std::ofstream(folder_ / "reels" / "wall" / "notes") << "secret";
  for (const char* target : {"/wall/notes", "/wall/", "/", "/wall/../../nginx/nginx.conf"}) {
    EXPECT_GE(RawHttpClient((*nginx)->port()).get(target).status, 400) << target;
  }
}

TEST_F(NginxTest, nginx_caches_packages_and_forwards_live_streams) {
  Background server("pointreel-server", {"serve", (folder_ / "reels" / "wall").string(), "--live",
                                         "--listen", "127.0.0.1:0"});
  const std::uint16_t port = port_of(server_address(server));
  ASSERT_NE(port, 0);
  const auto nginx = cache_of(port);
  ASSERT_TRUE(nginx) << nginx.error().message;
  const std::uint16_t front = (*nginx)->port();
  EXPECT_EQ(picture(fmt::format("http://127.0.0.1:{}/wall/reel.json", front), "there.png"),
            picture((folder_ / "reels" / "wall").string(), "here.png"));

  const auto asked = [&] {
    const std::string page = RawHttpClient(port).get("/metrics").body;
    return metric(page, "pointreel_http_responses_total{status=\"206\"}");
  };
  const std::string bytes = read_file(folder_ / "reels" / "wall" / base_);
  RawHttpClient client(front);
  EXPECT_EQ(client.get("/wall/" + base_, "Range: bytes=1-2\r\n").body, bytes.substr(1, 2));
  const double before = asked();
  for (std::size_t i = 0; i < 50; ++i) {
    const Answer answer =
        client.get("/wall/" + base_, fmt::format("Range: bytes={}-{}\r\n", i, i + 100));
    EXPECT_EQ(answer.status, 206);
    EXPECT_EQ(answer.field("content-range"),
              fmt::format("bytes {}-{}/{}", i, i + 100, bytes.size()));
    EXPECT_TRUE(answer.body == bytes.substr(i, 101));
    EXPECT_EQ(answer.field("x-cache"), "HIT");
  }
  EXPECT_EQ(asked(), before) << "nginx must not ask the server again";
  EXPECT_EQ(client.get("/metrics").status, 403);

  // Live: the publisher connects to the server, and viewers connect through nginx.
  Background publisher("pointreel-server", {"publish", "-i", (folder_ / "in").string(), "--to",
                                            fmt::format("ws://127.0.0.1:{}/live/stage", port),
                                            "--fps", "10", "--loop"});
  WebSocketOptions options;
  options.silence_timeout = 20s;
  Result<std::unique_ptr<WebSocket>> viewer = fail("");
  const std::string url = fmt::format("ws://127.0.0.1:{}/live/stage", front);
  wait_until([&] { return (viewer = WebSocket::connect(url, options)).has_value(); });
  ASSERT_TRUE(viewer) << viewer.error().message;
  int layers = 0;
  for (int i = 0; i < 20; ++i) {
    const auto message = (*viewer)->receive(20s);
    ASSERT_TRUE(message) << message.error().message;
    ASSERT_TRUE(*message);
    layers += (*message)->kind == WebSocket::Kind::binary ? 1 : 0;
  }
  EXPECT_GT(layers, 10);
  const auto denied = WebSocket::connect(url + "2?publish", options);
  ASSERT_FALSE(denied);
  EXPECT_EQ(denied.error().code, ErrorCode::refused) << "clients behind nginx are not local";

  // Live over HTTP: a growing manifest, and files that nginx caches for other viewers.
  const std::string manifest = fmt::format("http://127.0.0.1:{}/live/stage/reel.json", front);
  const auto many = [](const nlohmann::json& report) { return report["frames_shown"] > 5; };
  for (int time = 0; time < 2; ++time) {
    const auto report = play_until({manifest, "--mode", "point", "--offscreen", "64x48"}, many);
    ASSERT_FALSE(report.is_discarded());
    EXPECT_TRUE(many(report)) << report["frames_shown"];
  }
  const Answer live_manifest = client.get("/live/stage/reel.json");
  EXPECT_EQ(live_manifest.status, 200);
  const auto growing = nlohmann::json::parse(live_manifest.body, nullptr, false);
  ASSERT_FALSE(growing.is_discarded());
  const auto& files = growing["segments"][0]["files"];
  const std::string file = "/live/stage/" + files[0]["path"].get<std::string>();
  const Answer first = client.get(file), again = client.get(file);
  EXPECT_EQ(first.status, 200);
  EXPECT_EQ(first.body.size(), files[0]["bytes"].get<std::size_t>());
  EXPECT_EQ(again.field("x-cache"), "HIT");
  EXPECT_EQ(again.body, first.body);
}

/// Asks for a file from many connections at the same time.
std::vector<Answer> ask_at_once(std::uint16_t port, const std::string& target, int count) {
  std::vector<std::future<Answer>> asked;
  for (int i = 0; i < count; ++i) {
    asked.push_back(
        std::async(std::launch::async, [=] { return RawHttpClient(port).get(target); }));
  }
  std::vector<Answer> answers;
  for (auto& answer : asked) answers.push_back(answer.get());
  return answers;
}

TEST_F(NginxTest, a_chain_of_nginx_and_varnish_asks_the_server_once_for_many_viewers) {
  const std::string varnish = "/usr/sbin/varnishd";
  if (!fs::exists(varnish)) GTEST_SKIP() << "Varnish is not installed: apt-get install varnish";
  Background server("pointreel-server", {"serve", "--live", "--listen", "127.0.0.1:0"});
  const std::uint16_t port = port_of(server_address(server));
  ASSERT_NE(port, 0);
  const auto nginx = cache_of(port);
  ASSERT_TRUE(nginx) << nginx.error().message;
  std::ofstream(folder_ / "live.vcl")
      << nginx_configuration("live.vcl", {{"8090", std::to_string((*nginx)->port())}});
  std::uint16_t front = 0;
  {
    // Varnish cannot choose a free port and report it.
    Background other("pointreel-server", {"serve", "--live", "--listen", "127.0.0.1:0"});
    front = port_of(server_address(other));
  }
  Background cache(varnish, {"-F", "-a", fmt::format("127.0.0.1:{}", front), "-f",
                             (folder_ / "live.vcl").string(), "-n", (folder_ / "varnish").string(),
                             "-s", "malloc,64m", "-j", "none", "-T", "none"});
  ASSERT_TRUE(wait_until([&] {
    if (!cache.running()) return true;
    const int status = RawHttpClient(front).get("/healthz").status;
    return status == 200;
  }));
  ASSERT_TRUE(cache.running());
  Background publisher("pointreel-server", {"publish", "-i", (folder_ / "in").string(), "--to",
                                            fmt::format("ws://127.0.0.1:{}/live/stage", port),
                                            "--fps", "10", "--loop"});
  const std::string manifest = "/live/stage/reel.json";
  nlohmann::json growing;
  ASSERT_TRUE(wait_until([&] {
    const Answer answer = RawHttpClient(front).get(manifest);
    growing = nlohmann::json::parse(answer.body, nullptr, false);
    return answer.status == 200 && !growing.is_discarded() && growing["segments"].size() >= 2;
  }));
  const auto asked = [&] {
    return metric(RawHttpClient(port).get("/metrics").body,
                  "pointreel_http_responses_total{status=\"206\"}");
  };
  const auto& newest = growing["segments"].back()["files"][0];
  const std::string file = "/live/stage/" + newest["path"].get<std::string>();
  const double before = asked();
  for (const Answer& answer : ask_at_once(front, file, 32)) {
    EXPECT_EQ(answer.status, 200);
    EXPECT_EQ(answer.body.size(), newest["bytes"].get<std::size_t>());
  }
  EXPECT_LE(asked(), std::max(before, 0.0) + 1.0) << "one request for all viewers";
  for (const Answer& answer : ask_at_once(front, manifest, 32)) EXPECT_EQ(answer.status, 200);
  EXPECT_EQ(RawHttpClient(front).get("/metrics").status, 403);

  // A player behind both, over HTTP and over WebSocket.
  const auto many = [](const nlohmann::json& report) { return report["frames_shown"] > 5; };
  for (const char* address :
       {"http://127.0.0.1:{}/live/stage/reel.json", "ws://127.0.0.1:{}/live/stage"}) {
    const auto report = play_until(
        {fmt::format(fmt::runtime(address), front), "--mode", "point", "--offscreen", "64x48"},
        many);
    ASSERT_FALSE(report.is_discarded()) << address;
    EXPECT_TRUE(many(report)) << address << report["frames_shown"];
  }
}

}  // namespace
}  // namespace pointreel::e2e::nginx_test
