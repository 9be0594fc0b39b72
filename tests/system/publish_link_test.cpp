// Publishing over links with a delay: every frame arrives or is counted.

#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "client/source/live_source.h"
#include "client/source/websocket_live_source.h"
#include "codec/live/outbox.h"
#include "server/publish/publisher.h"
#include "server/relay/relay.h"
#include "server/serve/http_server.h"
#include "tests/link/link_emulator.h"
#include "tests/live_frames.h"
#include "tests/packed_clouds.h"
#include "tests/wait.h"

namespace pointreel::publish_link_test {
namespace {

using namespace std::chrono_literals;

/// A server behind a link.
class PublishLinkTest : public PackTest {
 protected:
  void start(std::chrono::milliseconds delay) {
    std::signal(SIGPIPE, SIG_IGN);
    link_.reset();
    server_.reset();
    relay_ = std::make_unique<Relay>();
    HttpServerOptions options;
    options.listen.port = 0;
    options.threads = 1;
    options.service.log = Log::Level::kOff;
    auto server = HttpServer::start({}, options, relay_.get());
    ASSERT_TRUE(server) << server.error().message;
    server_ = *std::move(server);
    auto link = LinkEmulator::start(
        {.target = fmt::format("127.0.0.1:{}", server_->port()), .conditions = {.delay = delay}});
    ASSERT_TRUE(link) << link.error().message;
    link_ = *std::move(link);
  }

  std::string stream() const { return "ws://" + link_->address() + "/live/stage"; }

  Result<PublishSummary> publish_files(double fps) {
    PublishOptions options;
    options.fps = fps;
    options.threads = 1;
    options.outbox.url = stream() + "?publish";
    const auto input = play_files(list_cloud_frames({frames_}).value(), fps, false);
    return publish(*input, options, {});
  }

  std::unique_ptr<WebSocket> fake_publisher() {
    WebSocketOptions options;
    options.silence_timeout = 60s;
    auto socket = WebSocket::connect(
        fmt::format("ws://127.0.0.1:{}/live/stage?publish", server_->port()), options);
    if (!socket) return nullptr;
    const LiveMessage hello = publisher_message(1);
    if (!(*socket)->send(*hello.bytes, WebSocket::Kind::text)) return nullptr;
    return *std::move(socket);
  }

  std::unique_ptr<Relay> relay_;
  std::unique_ptr<HttpServer> server_;
  std::unique_ptr<LinkEmulator> link_;
};

TEST_F(PublishLinkTest,
       a_round_trip_of_more_than_a_second_delays_a_stream_but_does_not_prevent_it) {
  ::write_frames(frames_, 3);
  start(600ms);
  const auto summary = publish_files(20.0);
  ASSERT_TRUE(summary) << summary.error().message;
  EXPECT_EQ(summary->sent.accepted_frames + summary->skipped, 3u) << summary->trouble;
  EXPECT_GT(summary->sent.accepted_frames, 0u);
  EXPECT_EQ(summary->trouble, "");
}

/// Every frame is in exactly one of the counts.
void expect_sum(const PublishSummary& summary, std::uint64_t frames) {
  EXPECT_EQ(summary.frames + summary.skipped + summary.unusable, frames);
  EXPECT_EQ(summary.sent.accepted_frames + summary.sent.drops.frames, summary.frames);
}

TEST_F(PublishLinkTest, no_frame_is_lost_because_the_link_is_slow_to_connect) {
  for (const int frames : {1, 3, 9}) {
    ::write_frames(frames_, static_cast<std::size_t>(frames));
    for (const auto delay : {0ms, 30ms, 100ms, 300ms}) {
      SCOPED_TRACE(fmt::format("{} frames, delay {} ms", frames, delay.count()));
      start(delay);
      const auto summary = publish_files(30.0);
      ASSERT_TRUE(summary) << summary.error().message;
      expect_sum(*summary, static_cast<std::uint64_t>(frames));
      // So few frames fit into the queue however slow this machine is.
      if (frames <= 4) {
        EXPECT_EQ(summary->sent.drops.frames, 0u);
      }
      EXPECT_EQ(summary->trouble, "");
    }
  }
}

TEST_F(PublishLinkTest, frames_that_a_broken_link_loses_count_as_dropped) {
  ::write_frames(frames_, 12);
  for (const int breaks_after_ms : {0, 50, 120, 200, 260}) {
    SCOPED_TRACE(breaks_after_ms);
    start(20ms);
    ASSERT_TRUE(link_->run({{std::chrono::milliseconds(40 + breaks_after_ms), "reset"},
                            {std::chrono::milliseconds(90 + breaks_after_ms), "reset"}}));
    const auto summary = publish_files(40.0);
    ASSERT_TRUE(summary) << summary.error().message;
    expect_sum(*summary, 12);
    EXPECT_GT(summary->sent.accepted_frames, 0u);
  }
}

TEST_F(PublishLinkTest, a_publisher_whose_token_is_not_valid_any_more_waits_until_it_is) {
  start(0ms);
  server_->set_tokens("", "show");
  Outbox outbox({.url = stream() + "?publish", .token = "show"});
  outbox.hello(publisher_message());
  std::uint32_t frame = 0;
  const auto is_accepted = [&] {
    const std::uint64_t before = outbox.statistics().accepted_frames;
    outbox.push(++frame, {layer_message(frame, 0, 1)});
    return wait_until([&] { return outbox.statistics().accepted_frames > before; });
  };
  ASSERT_TRUE(is_accepted());
  server_->set_tokens("", "other");
  ASSERT_TRUE(link_->run({{0ms, "reset"}}));
  EXPECT_TRUE(wait_until([&] { return outbox.trouble().find("401") != std::string::npos; }));
  EXPECT_FALSE(outbox.failure());
  server_->set_tokens("", "show");
  EXPECT_TRUE(is_accepted());
  EXPECT_EQ(outbox.trouble(), "");
}

TEST_F(PublishLinkTest, a_viewer_behind_such_a_round_trip_stays_connected_while_nothing_comes) {
  start(600ms);
  const auto publisher = fake_publisher();
  ASSERT_TRUE(publisher);
  ASSERT_TRUE(wait_until([&] { return !relay_->statistics().empty(); }));
  const auto source = open_websocket_live_source(stream(), {}).value();
  ASSERT_TRUE(source->hello(30s)) << source->trouble().value_or("no trouble");
  // Longer than a viewer waits for a sign of life, and for another attempt to connect.
  EXPECT_FALSE(wait_until([&] { return source->trouble().has_value(); }, 4s));
  const LiveMessage layer = layer_message(0, 0, 1);
  ASSERT_TRUE(publisher->send(*layer.bytes, WebSocket::Kind::binary));
  EXPECT_TRUE(source->next(30s));
  EXPECT_EQ(source->counts().reconnections, 0u);
}

TEST_F(PublishLinkTest, sound_comes_to_those_alone_who_asked_for_it) {
  start(0ms);
  const auto publisher = fake_publisher();
  ASSERT_TRUE(publisher);
  ASSERT_TRUE(wait_until([&] { return !relay_->statistics().empty(); }));
  std::atomic<int> silent_packets = 0, packets = 0;
  SourceOptions with_sound;
  with_sound.sound = true;
  const auto silent = open_websocket_live_source(stream(), {}).value();
  const auto heard = open_websocket_live_source(stream(), with_sound).value();
  silent->set_on_sound([&](const LiveSound&) { ++silent_packets; });
  heard->set_on_sound([&](const LiveSound&) { ++packets; });
  ASSERT_TRUE(silent->hello(30s));
  ASSERT_TRUE(heard->hello(30s));
  const Bytes packet = {1, 2, 3};
  ASSERT_TRUE(publisher->send(write_live_sound({1, 20'000, 960, packet}), WebSocket::Kind::binary));
  const LiveMessage layer = layer_message(0, 0, 1);
  ASSERT_TRUE(publisher->send(*layer.bytes, WebSocket::Kind::binary));
  // Sound goes before layers.
  EXPECT_TRUE(silent->next(30s));
  EXPECT_TRUE(heard->next(30s));
  EXPECT_EQ(silent_packets, 0);
  EXPECT_EQ(packets, 1);
}

}  // namespace
}  // namespace pointreel::publish_link_test
