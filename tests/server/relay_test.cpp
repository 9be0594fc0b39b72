// Live streams from publishers to viewers, without sockets.

#include "server/relay/relay.h"

#include <atomic>
#include <chrono>
#include <string>
#include <thread>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/live_frames.h"

namespace pointreel::relay_test {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

LiveMessage hello_message(std::uint8_t publisher = 1) { return publisher_message(publisher); }

void publish_frame(Publication& publication, std::uint32_t frame) {
  for (std::uint8_t i = 0; i < 3; ++i) {
    const auto taken = publication.message(layer_message(frame, i));
    ASSERT_TRUE(taken) << taken.error().message;
  }
}

std::vector<std::string> take_all(Viewer& viewer) {
  std::vector<std::string> taken;
  while (const auto message = viewer.next()) taken.push_back(brief(*message));
  return taken;
}

std::string refusal(Publication& publication, LiveMessage message) {
  const auto taken = publication.message(std::move(message));
  return taken ? std::string() : taken.error().message;
}

/// Keeps the hellos.
class Hellos : public LiveSink {
 public:
  explicit Hellos(std::vector<LiveHello>& hellos) : hellos_(hellos) {}
  void hello(const LiveHello& hello) override { hellos_.push_back(hello); }
  void layer(const LiveLayer&, const LiveMessage&) override {}
  void end() override {}

 private:
  std::vector<LiveHello>& hellos_;
};

RelayOptions with_sink(std::shared_ptr<LiveSink> sink) {
  RelayOptions options;
  options.sinks = [sink](const std::string&) { return std::vector{sink}; };
  return options;
}

TEST(Relay, a_viewer_receives_the_newest_frame_on_joining_and_then_every_later_one) {
  Relay relay;
  const auto publication = relay.publish("stage").value();
  ASSERT_TRUE(publication->message(hello_message()));
  publish_frame(*publication, 3);
  ASSERT_TRUE(publication->message(layer_message(4, 0)));
  const auto viewer = relay.join("stage", [] {}).value();
  EXPECT_THAT(take_all(*viewer), ElementsAre("hello", "4.0"));
  ASSERT_TRUE(publication->message(layer_message(4, 1)));
  publish_frame(*publication, 5);
  EXPECT_THAT(take_all(*viewer), ElementsAre("4.1", "5.0", "5.1", "5.2"));
}

TEST(Relay, a_viewer_is_woken_once_when_new_messages_wait) {
  Relay relay;
  const auto publication = relay.publish("stage").value();
  ASSERT_TRUE(publication->message(hello_message()));
  int woken = 0;
  const auto viewer = relay.join("stage", [&] { ++woken; }).value();
  publish_frame(*publication, 0);
  EXPECT_EQ(woken, 0) << "the viewer has not taken anything yet";
  take_all(*viewer);
  publish_frame(*publication, 1);
  EXPECT_EQ(woken, 1);
  take_all(*viewer);
  publish_frame(*publication, 2);
  EXPECT_EQ(woken, 2);
}

TEST(Relay, a_stream_cannot_be_joined_before_it_is_published) {
  Relay relay;
  EXPECT_FALSE(relay.join("stage", [] {}));
  EXPECT_FALSE(relay.publish("../stage"));
  const auto publication = relay.publish("stage").value();
  EXPECT_FALSE(publication->greeted());
  EXPECT_FALSE(relay.join("stage", [] {})) << "a connection alone is no stream";
  ASSERT_TRUE(publication->message(hello_message()));
  EXPECT_TRUE(publication->greeted());
  EXPECT_TRUE(relay.join("stage", [] {}));
}

TEST(Relay, messages_out_of_order_end_the_publication) {
  Relay relay;
  const auto publication = relay.publish("stage").value();
  EXPECT_THAT(refusal(*publication, layer_message(0, 0)), HasSubstr("hello"));
  EXPECT_THAT(refusal(*publication, text_message("{}")), HasSubstr("type"));
  EXPECT_THAT(refusal(*publication, text_message(write_end())), HasSubstr("hellos and layers"));
  ASSERT_TRUE(publication->message(hello_message()));
  EXPECT_THAT(refusal(*publication, hello_message(2)), HasSubstr("secret"));
  EXPECT_THAT(refusal(*publication, layer_message(0, 1)), HasSubstr("does not follow"));
  ASSERT_TRUE(publication->message(layer_message(7, 0)));
  EXPECT_THAT(refusal(*publication, layer_message(7, 2)), HasSubstr("does not follow"));
  EXPECT_THAT(refusal(*publication, layer_message(8, 1)), HasSubstr("does not follow"));
  EXPECT_THAT(refusal(*publication, layer_message(7, 0)), HasSubstr("frame 7 after 7"));
  EXPECT_THAT(refusal(*publication, layer_message(8, 0, 4)), HasSubstr("4 layers"));
  EXPECT_THAT(refusal(*publication, layer_message(8, 0, 3, 10)),
              HasSubstr("not a Pointreel frame"));
  LiveMessage damaged = layer_message(8, 0);
  Bytes bytes = *damaged.bytes;
  bytes[5] ^= 1;
  damaged.bytes = std::make_shared<const Bytes>(bytes);
  EXPECT_THAT(refusal(*publication, damaged), HasSubstr("damaged"));
}

TEST(Relay, a_frame_that_exceeds_its_hello_or_what_viewers_decode_is_refused) {
  Relay relay;
  const auto publication = relay.publish("stage").value();
  ASSERT_TRUE(publication->message(hello_message()));
  const auto refused = [&](FrameHeader frame) {
    return refusal(*publication, layer_message(0, 0, 1, kFrameHeaderSize, frame));
  };
  EXPECT_THAT(refused({.has_colors = true, .cube = {}}), HasSubstr("has colours"));
  EXPECT_THAT(refused({.has_normals = true, .cube = {}}), HasSubstr("has normals"));
  EXPECT_THAT(refused({.layers = 4, .cube = {}}), HasSubstr("4 layers, the hello names 3"));
  const std::uint32_t most = DecodeLimits().max_points;
  EXPECT_THAT(refused({.source_points = most + 1, .cube = {}}), HasSubstr("viewers decode"));
  EXPECT_EQ(relay.statistics().front().frames, 0u) << "neither viewers nor recordings got one";
  EXPECT_EQ(refused({.layers = 3, .source_points = most, .cube = {}}), "");
}

TEST(Relay, text_messages_of_unknown_types_are_accepted) {
  Relay relay;
  const auto publication = relay.publish("stage").value();
  EXPECT_TRUE(publication->message(text_message(R"({"type": "weather"})")));
}

TEST(Relay, a_second_publisher_of_a_stream_is_refused) {
  Relay relay;
  const auto one = relay.publish("stage").value();
  ASSERT_TRUE(one->message(hello_message(1)));
  const auto other = relay.publish("stage").value();
  EXPECT_THAT(refusal(*other, hello_message(2)), HasSubstr("somebody else"));
  publish_frame(*one, 0);
  const auto elsewhere = relay.publish("hall").value();
  EXPECT_TRUE(elsewhere->message(hello_message(2)));
}

TEST(Relay, a_publisher_that_reconnects_replaces_its_old_connection) {
  Relay relay;
  auto old = relay.publish("stage").value();
  ASSERT_TRUE(old->message(hello_message(1)));
  publish_frame(*old, 0);
  const auto viewer = relay.join("stage", [] {}).value();
  take_all(*viewer);
  const auto anew = relay.publish("stage").value();
  ASSERT_TRUE(anew->message(hello_message(1)));
  EXPECT_THAT(refusal(*old, layer_message(1, 0)), HasSubstr("anew"));
  old.reset();
  publish_frame(*anew, 0);  // the viewer already has frame 0 and does not get it again
  publish_frame(*anew, 1);
  EXPECT_THAT(refusal(*anew, layer_message(0, 0)), HasSubstr("after")) << "numbers must increase";
  EXPECT_THAT(take_all(*viewer), ElementsAre("hello", "1.0", "1.1", "1.2"));
}

TEST(Relay, nothing_that_viewers_sinks_or_statistics_get_lets_them_publish) {
  std::vector<LiveHello> heard;
  Relay relay(with_sink(std::make_shared<Hellos>(heard)));
  auto owner = relay.publish("stage").value();
  LiveSecret secret;
  secret.fill(0xab);
  ASSERT_TRUE(owner->message(text_message(write_publisher_hello(plain_hello(), {secret}))));
  const auto viewer = relay.join("stage", [] {}).value();
  const auto seen = viewer->next().value();
  const std::string text(seen.bytes->begin(), seen.bytes->end());
  EXPECT_THAT(text, testing::Not(testing::AnyOf(HasSubstr("secret"), HasSubstr("abab"))));
  const auto hello = std::get<LiveHello>(parse_live_text(text).value());
  EXPECT_THAT(heard, ElementsAre(hello));
  EXPECT_NE(hello.session, 0u);

  // Whatever a viewer makes of the session, it is not the secret.
  owner.reset();
  const auto thief = relay.publish("stage").value();
  EXPECT_THAT(refusal(*thief, text_message(text)), HasSubstr("secret"));
  for (int shift = 0; shift < 64; shift += 8) {
    LiveSecret guess;
    for (std::size_t i = 0; i < guess.size(); ++i) {
      guess[i] = static_cast<std::uint8_t>(hello.session >> ((shift + 8 * i) % 64));
    }
    EXPECT_THAT(refusal(*thief, text_message(write_publisher_hello(plain_hello(), {guess}))),
                HasSubstr("kept"));
  }
  EXPECT_FALSE(relay.statistics()[0].publishing);
}

TEST(Relay, a_publisher_that_was_started_again_takes_its_name_back) {
  Relay relay;
  LiveSecret first, second, third;
  first.fill(1), second.fill(2), third.fill(3);
  const auto hello = [](const LiveIdentity& identity) {
    return text_message(write_publisher_hello(plain_hello(), identity));
  };
  const auto killed = relay.publish("stage").value();
  ASSERT_TRUE(killed->message(hello({first})));
  const auto viewer = relay.join("stage", [] {}).value();
  const auto session = [&] {
    const auto seen = viewer->next().value();
    const std::string text(seen.bytes->begin(), seen.bytes->end());
    return std::get<LiveHello>(parse_live_text(text).value()).session;
  };
  const std::uint64_t before = session();
  // Its connection may still look alive.
  const auto again = relay.publish("stage").value();
  EXPECT_THAT(refusal(*again, hello({second, third})), HasSubstr("somebody else publishes"));
  ASSERT_TRUE(again->message(hello({second, first})));
  EXPECT_NE(session(), before);
  EXPECT_THAT(refusal(*killed, layer_message(0, 0)), HasSubstr("connected anew"));
  // It says more of its stream, and nobody takes over by a secret that is no longer valid.
  ASSERT_TRUE(again->message(hello({second, first})));
  const auto late = relay.publish("stage").value();
  EXPECT_THAT(refusal(*late, hello({third, first})), HasSubstr("somebody else publishes"));
}

TEST(Relay,
     a_session_is_the_same_after_the_server_was_started_again_and_differs_between_publishers) {
  const auto session = [](std::uint8_t publisher) {
    Relay relay;
    const auto publication = relay.publish("stage").value();
    EXPECT_TRUE(publication->message(hello_message(publisher)));
    const auto seen = relay.join("stage", [] {}).value()->next().value();
    const std::string text(seen.bytes->begin(), seen.bytes->end());
    return std::get<LiveHello>(parse_live_text(text).value()).session;
  };
  EXPECT_EQ(session(1), session(1));
  EXPECT_NE(session(1), session(2));
}

TEST(Relay, a_name_belongs_to_its_publisher_until_it_has_been_gone_for_the_grace_time) {
  RelayOptions options;
  RelayOptions::Clock::time_point now{std::chrono::hours(1)};
  options.now = [&now] { return now; };
  options.grace = std::chrono::seconds(10);
  options.max_streams = 1;
  Relay relay(options);
  auto owner = relay.publish("stage").value();
  ASSERT_TRUE(owner->message(hello_message(1)));
  publish_frame(*owner, 0);
  owner.reset();  // the connection is lost
  now += std::chrono::milliseconds(9'999);
  const auto other = relay.publish("stage").value(), elsewhere = relay.publish("hall").value();
  EXPECT_THAT(refusal(*other, hello_message(2)), HasSubstr("kept for 1 s"));
  EXPECT_THAT(refusal(*elsewhere, hello_message(2)), HasSubstr("streams already"))
      << "a stream whose publisher may come back must not be replaced";
  owner = relay.publish("stage").value();
  ASSERT_TRUE(owner->message(hello_message(1)));
  publish_frame(*owner, 1);
  owner.reset();
  now += std::chrono::seconds(10);
  EXPECT_EQ(refusal(*other, hello_message(2)), "");
  owner = relay.publish("stage").value();
  EXPECT_THAT(refusal(*owner, hello_message(1)), HasSubstr("somebody else"));
}

TEST(Relay, a_publisher_that_says_goodbye_frees_its_name_at_once) {
  Relay relay;
  auto first = relay.publish("stage").value();
  ASSERT_TRUE(first->message(hello_message(1)));
  first->end();
  first.reset();
  const auto second = relay.publish("stage").value();
  EXPECT_EQ(refusal(*second, hello_message(2)), "");
}

TEST(Relay, connections_without_a_hello_hold_no_stream) {
  RelayOptions options;
  options.max_streams = 2;
  Relay relay(options);
  std::vector<std::unique_ptr<Publication>> silent;
  for (int i = 0; i < 100; ++i) {
    silent.push_back(relay.publish("stage" + std::to_string(i)).value());
    EXPECT_TRUE(silent.back()->message(text_message(R"({"type": "weather"})")));
  }
  EXPECT_THAT(relay.statistics(), IsEmpty());
  const auto publication = relay.publish("stage7").value();
  EXPECT_EQ(refusal(*publication, hello_message(1)), "");
}

TEST(Relay, a_hello_may_not_take_back_what_it_has_stated_about_earlier_frames) {
  LiveHello hello = plain_hello();
  hello.colors = true;
  hello.bounds = {{0, 0, 0}, {1, 1, 1}};
  Relay relay;
  const auto publication = relay.publish("stage").value();
  ASSERT_TRUE(publication->message(publisher_message(1, hello)));
  const auto refused = [&](auto change) {
    LiveHello changed = hello;
    change(changed);
    return refusal(*publication, publisher_message(1, changed));
  };
  EXPECT_THAT(refused([](LiveHello& h) { h.colors = false; }), HasSubstr("takes back"));
  EXPECT_THAT(refused([](LiveHello& h) { h.bounds = {}; }), HasSubstr("takes back"));
  EXPECT_THAT(refused([](LiveHello& h) { h.bounds.max.y = 0.5; }), HasSubstr("takes back"));
  EXPECT_EQ(refused([](LiveHello& h) { h.bounds.grow(glm::dvec3(2.0)); }), "");
}

TEST(Relay, viewers_stay_when_the_publisher_leaves_and_see_the_next_one) {
  Relay relay;
  auto publication = relay.publish("stage").value();
  ASSERT_TRUE(publication->message(hello_message(1)));
  publish_frame(*publication, 9);
  int woken = 0;
  const auto viewer = relay.join("stage", [&] { ++woken; }).value();
  take_all(*viewer);
  publication->end();
  publication.reset();
  EXPECT_EQ(woken, 1);
  EXPECT_THAT(take_all(*viewer), ElementsAre("end"));
  const auto late = relay.join("stage", [] {}).value();
  EXPECT_THAT(take_all(*late), ElementsAre("hello", "9.0", "9.1", "9.2", "end"));
  publication = relay.publish("stage").value();
  ASSERT_TRUE(publication->message(hello_message(2)));
  publish_frame(*publication, 0);
  EXPECT_THAT(take_all(*viewer), ElementsAre("hello", "0.0", "0.1", "0.2"));
}

TEST(Relay, slow_viewers_never_delay_others) {
  Relay relay;
  const auto publication = relay.publish("stage").value();
  ASSERT_TRUE(publication->message(hello_message()));
  const auto fast = relay.join("stage", [] {}).value();
  const auto slow = relay.join("stage", [] {}).value();
  take_all(*fast);
  for (std::uint32_t frame = 0; frame < 100; ++frame) {
    publish_frame(*publication, frame);
    EXPECT_EQ(take_all(*fast).size(), 3u);
  }
  const auto left = take_all(*slow);
  EXPECT_EQ(left.back(), "99.0");
  const auto statistics = relay.statistics();
  ASSERT_EQ(statistics.size(), 1u);
  EXPECT_EQ(statistics[0].name, "stage");
  EXPECT_TRUE(statistics[0].publishing);
  EXPECT_EQ(statistics[0].viewers, 2u);
  EXPECT_EQ(statistics[0].frames, 100u);
  EXPECT_EQ(statistics[0].layers, 300u);
  EXPECT_GT(statistics[0].drops.frames, 90u);
  EXPECT_EQ(statistics[0].newest_capture_us, 1'000'000u + 33'333u * 99);
}

TEST(Relay, statistics_include_the_drops_of_viewers_that_have_left) {
  Relay relay;
  const auto publication = relay.publish("stage").value();
  ASSERT_TRUE(publication->message(hello_message()));
  auto viewer = relay.join("stage", [] {}).value();
  for (std::uint32_t frame = 0; frame < 20; ++frame) publish_frame(*publication, frame);
  const LiveDrops drops = relay.statistics()[0].drops;
  EXPECT_GT(drops.layers, 0u);
  viewer.reset();
  EXPECT_EQ(relay.statistics()[0].drops, drops);
  EXPECT_EQ(relay.statistics()[0].viewers, 0u);
}

TEST(Relay, a_new_stream_beyond_the_limit_replaces_the_one_that_ended_first) {
  RelayOptions options;
  options.max_streams = 2;
  Relay relay(options);
  auto a = relay.publish("a").value(), b = relay.publish("b").value();
  ASSERT_TRUE(a->message(hello_message(1)) && b->message(hello_message(2)));
  const auto c = relay.publish("c").value();
  EXPECT_THAT(refusal(*c, hello_message(3)), HasSubstr("there are 2 streams already"));
  b->end();
  b.reset();
  a->end();
  a.reset();
  EXPECT_EQ(refusal(*c, hello_message(3)), "");
  EXPECT_TRUE(relay.join("a", [] {}));
  EXPECT_FALSE(relay.join("b", [] {}));
}

/// Records each call in a word.
class Notes : public LiveSink {
 public:
  explicit Notes(std::vector<std::string>& notes) : notes_(notes) {}
  void hello(const LiveHello& hello) override { notes_.push_back(hello.name); }
  void layer(const LiveLayer& layer, const LiveMessage& message) override {
    EXPECT_EQ(layer.bytes.data(), message.bytes->data() + kLiveHeaderSize);
    notes_.push_back(brief(message));
  }
  void end() override { notes_.push_back("end"); }

 private:
  std::vector<std::string>& notes_;
};

TEST(Relay, sinks_receive_a_whole_stream_regardless_of_viewers) {
  std::vector<std::string> notes;
  RelayOptions options;
  options.sinks = [&](const std::string& name) {
    EXPECT_EQ(name, "stage");
    return std::vector<std::shared_ptr<LiveSink>>{std::make_shared<Notes>(notes)};
  };
  Relay relay(options);
  auto publication = relay.publish("stage").value();
  ASSERT_TRUE(publication->message(hello_message()));
  publish_frame(*publication, 0);
  publication.reset();
  EXPECT_THAT(notes, ElementsAre("plain", "0.0", "0.1", "0.2", "end"));
}

TEST(Relay, publishers_viewers_and_statistics_may_use_any_thread) {
  Relay relay;
  const auto first = relay.publish("stage").value();
  ASSERT_TRUE(first->message(hello_message()));
  std::atomic<bool> done = false;
  std::atomic<int> taken = 0;
  std::vector<std::thread> threads;
  for (int i = 0; i < 3; ++i) {
    threads.emplace_back([&] {
      while (!done) {
        std::atomic<int> woken = 0;
        const auto viewer = relay.join("stage", [&] { ++woken; }).value();
        for (int j = 0; j < 20; ++j) {
          while (viewer->next()) ++taken;
        }
        relay.statistics();
      }
    });
  }
  for (std::uint32_t frame = 0; frame < 300; ++frame) publish_frame(*first, frame);
  done = true;
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(relay.statistics()[0].viewers, 0u);
}

LiveMessage server_hello(std::uint64_t session, std::vector<std::uint64_t> servers) {
  LiveHello hello = plain_hello(session);
  hello.servers = std::move(servers);
  return text_message(write_hello(hello));
}

std::string text_of(const LiveMessage& message) {
  return {message.bytes->begin(), message.bytes->end()};
}

TEST(Relay, a_stream_from_another_server_keeps_its_session_and_names_the_servers_on_its_way) {
  std::vector<LiveHello> hellos;
  RelayOptions options = with_sink(std::make_shared<Hellos>(hellos));
  options.server = 0xb;
  Relay relay(options);
  const auto from = relay.receive("stage").value();
  ASSERT_TRUE(from->message(server_hello(77, {0xa})));
  publish_frame(*from, 3);
  const auto viewer = relay.join("stage", [] {}).value();
  EXPECT_THAT(take_all(*viewer), ElementsAre("hello", "3.0", "3.1", "3.2"));
  ASSERT_EQ(hellos.size(), 1u);
  EXPECT_EQ(hellos[0].session, 77u);
  EXPECT_THAT(hellos[0].servers, ElementsAre(0xau, 0xbu));
  EXPECT_EQ(relay.statistics().at(0).hops, 1u);
  // The publisher goes, and another one comes, over the same connection.
  ASSERT_TRUE(from->message(text_message(write_end())));
  EXPECT_FALSE(relay.statistics().at(0).publishing);
  EXPECT_THAT(refusal(*from, layer_message(4, 0)), HasSubstr("hello"));
  ASSERT_TRUE(from->message(server_hello(78, {0xa})));
  publish_frame(*from, 0);
  ASSERT_TRUE(from->message(server_hello(79, {0xa})));
  publish_frame(*from, 0);
  EXPECT_EQ(hellos.back().session, 79u);
}

TEST(Relay, a_stream_that_comes_around_in_a_circle_or_from_too_far_is_refused) {
  RelayOptions options;
  options.server = 0xb;
  Relay relay(options);
  const auto from = relay.receive("stage").value();
  EXPECT_THAT(refusal(*from, server_hello(1, {0xb})), HasSubstr("circle"));
  EXPECT_THAT(refusal(*from, server_hello(1, {0xa, 0xb, 0xc})), HasSubstr("circle"));
  EXPECT_THAT(refusal(*from, server_hello(1, std::vector<std::uint64_t>(kMaxLiveServers, 0xa))),
              HasSubstr("8 servers"));
  EXPECT_THAT(relay.statistics(), IsEmpty());
  EXPECT_TRUE(from->message(server_hello(1, std::vector<std::uint64_t>(kMaxLiveServers - 1, 0xa))));
}

TEST(Relay, another_server_that_breaks_the_rules_is_refused_like_a_publisher) {
  Relay relay;
  const auto from = relay.receive("stage").value();
  EXPECT_THAT(refusal(*from, layer_message(0, 0)), HasSubstr("hello"));
  EXPECT_THAT(refusal(*from, text_message("{")), Not(IsEmpty()));
  EXPECT_THAT(refusal(*from, hello_message()), HasSubstr("session"));
  ASSERT_TRUE(from->message(server_hello(1, {0xa})));
  publish_frame(*from, 3);
  EXPECT_THAT(refusal(*from, layer_message(3, 0)), HasSubstr("frame 3 after 3"));
  EXPECT_THAT(refusal(*from, layer_message(5, 1)), HasSubstr("does not follow"));
  EXPECT_THAT(refusal(*from, layer_message(5, 0, 4)), HasSubstr("4 layers"));
}

TEST(Relay, a_publisher_and_another_server_cannot_take_each_others_stream) {
  Relay relay;
  const auto publisher = relay.publish("stage").value();
  ASSERT_TRUE(publisher->message(hello_message()));
  const auto viewer = relay.join("stage", [] {}).value();
  const auto hello = viewer->next();
  ASSERT_TRUE(hello);
  const auto seen = std::get<LiveHello>(parse_live_text(text_of(*hello)).value());
  const auto from = relay.receive("stage").value();
  EXPECT_THAT(refusal(*from, server_hello(seen.session, {0xa})), HasSubstr("somebody else"))
      << "the session is no secret";
  const auto other = relay.receive("other").value();
  ASSERT_TRUE(other->message(server_hello(1, {0xa})));
  const auto second = relay.publish("other").value();
  EXPECT_THAT(refusal(*second, hello_message(2)), HasSubstr("somebody else"));
}

TEST(Relay, the_name_of_a_stream_from_another_server_is_free_when_the_connection_is_lost) {
  Relay relay;
  auto from = relay.receive("stage").value();
  ASSERT_TRUE(from->message(server_hello(1, {0xa})));
  publish_frame(*from, 3);
  from.reset();
  // It comes back, and sends its newest frame once more.
  from = relay.receive("stage").value();
  ASSERT_TRUE(from->message(server_hello(1, {0xa})));
  publish_frame(*from, 3);
  publish_frame(*from, 4);
  EXPECT_EQ(relay.statistics().at(0).frames, 2u);
  from.reset();
  const auto publisher = relay.publish("stage").value();
  EXPECT_TRUE(publisher->message(hello_message()));
}

TEST(Relay, of_two_servers_with_the_same_stream_the_second_waits_until_the_first_has_gone) {
  Relay relay;
  auto first = relay.receive("stage").value();
  const auto second = relay.receive("stage").value();
  ASSERT_TRUE(first->message(server_hello(1, {0xa})));
  publish_frame(*first, 3);
  EXPECT_THAT(refusal(*second, server_hello(1, {0xc})), HasSubstr("somebody else"));
  publish_frame(*first, 4);
  first.reset();
  ASSERT_TRUE(second->message(server_hello(1, {0xc})));
  publish_frame(*second, 4);
  publish_frame(*second, 5);
  EXPECT_EQ(relay.statistics().at(0).frames, 3u);
}

TEST(Relay, what_servers_before_could_not_send_is_counted_over_all_connections) {
  Relay relay;
  auto from = relay.receive("stage").value();
  ASSERT_TRUE(from->message(server_hello(1, {0xa})));
  for (const LiveDrops drops : {LiveDrops{2, 5}, LiveDrops{3, 9}})
    ASSERT_TRUE(from->message(text_message(write_drops(drops))));
  from = nullptr;
  from = relay.receive("stage").value();
  ASSERT_TRUE(from->message(server_hello(1, {0xa})));
  ASSERT_TRUE(from->message(text_message(write_drops({1, 1}))));
  EXPECT_EQ(relay.statistics().at(0).lost, (LiveDrops{4, 10}));
  ASSERT_TRUE(from->message(text_message(write_drops({0, 0})))) << "counts backward";
  EXPECT_EQ(relay.statistics().at(0).lost, (LiveDrops{4, 10}));
}

TEST(Relay, whoever_watches_is_told_the_names_of_streams_when_they_change) {
  Relay relay;
  int woken = 0;
  const auto list = relay.watch([&] { ++woken; });
  const auto names = [&]() -> std::vector<std::string> {
    const auto message = list->next();
    if (!message) return {"nothing new"};
    EXPECT_FALSE(list->next());
    return std::get<LiveStreams>(parse_live_text(text_of(*message)).value()).names;
  };
  EXPECT_THAT(names(), IsEmpty());
  EXPECT_THAT(names(), ElementsAre("nothing new"));
  auto a = relay.publish("a").value();
  EXPECT_EQ(woken, 0);
  ASSERT_TRUE(a->message(hello_message(1)));
  EXPECT_EQ(woken, 1);
  EXPECT_THAT(names(), ElementsAre("a"));
  const auto b = relay.receive("b").value();
  ASSERT_TRUE(b->message(server_hello(2, {0xa})));
  EXPECT_THAT(names(), ElementsAre("a", "b"));
  a.reset();
  EXPECT_THAT(names(), ElementsAre("b"));
  ASSERT_TRUE(b->message(text_message(write_end())));
  EXPECT_THAT(names(), IsEmpty());
}

}  // namespace
}  // namespace pointreel::relay_test
