// Live streams from publishers to viewers, without sockets.

#include "server/relay/relay.h"

#include <atomic>
#include <string>
#include <thread>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/unit/live_frames.h"

namespace pointreel {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

LiveMessage hello_message(std::uint64_t session = 1) {
  return text_message(write_hello(plain_hello(session)));
}

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
  const auto viewer = relay.join("stage", [] {});
  ASSERT_TRUE(viewer);
}

TEST(Relay, messages_out_of_order_end_the_publication) {
  Relay relay;
  const auto publication = relay.publish("stage").value();
  EXPECT_THAT(refusal(*publication, layer_message(0, 0)), HasSubstr("hello"));
  EXPECT_THAT(refusal(*publication, text_message("{}")), HasSubstr("type"));
  EXPECT_THAT(refusal(*publication, text_message(write_end())), HasSubstr("hellos and layers"));
  ASSERT_TRUE(publication->message(hello_message()));
  EXPECT_THAT(refusal(*publication, hello_message(2)), HasSubstr("session"));
  EXPECT_THAT(refusal(*publication, layer_message(0, 1)), HasSubstr("does not follow"));
  ASSERT_TRUE(publication->message(layer_message(7, 0)));
  EXPECT_THAT(refusal(*publication, layer_message(7, 2)), HasSubstr("does not follow"));
  EXPECT_THAT(refusal(*publication, layer_message(8, 1)), HasSubstr("does not follow"));
  EXPECT_THAT(refusal(*publication, layer_message(7, 0)), HasSubstr("frame 7 after 7"));
  EXPECT_THAT(refusal(*publication, layer_message(8, 0, 4)), HasSubstr("4 layers"));
  LiveMessage damaged = layer_message(8, 0);
  Bytes bytes = *damaged.bytes;
  bytes[5] ^= 1;
  damaged.bytes = std::make_shared<const Bytes>(bytes);
  EXPECT_THAT(refusal(*publication, damaged), HasSubstr("damaged"));
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

TEST(Relay, viewers_stay_when_the_publisher_leaves_and_see_the_next_one) {
  Relay relay;
  auto publication = relay.publish("stage").value();
  ASSERT_TRUE(publication->message(hello_message(1)));
  publish_frame(*publication, 9);
  int woken = 0;
  const auto viewer = relay.join("stage", [&] { ++woken; }).value();
  take_all(*viewer);
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
  Relay relay({.max_streams = 2, .viewer = {}, .sinks = {}});
  auto a = relay.publish("a").value();
  auto b = relay.publish("b").value();
  EXPECT_FALSE(relay.publish("c"));
  b.reset();
  a.reset();
  const auto c = relay.publish("c");
  ASSERT_TRUE(c);
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

}  // namespace
}  // namespace pointreel
