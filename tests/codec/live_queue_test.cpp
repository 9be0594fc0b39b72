// The messages that wait for a viewer, and those dropped when the viewer is too slow.

#include "codec/live/live_queue.h"

#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/live_frames.h"

namespace pointreel::live_queue_test {
namespace {

using testing::Contains;
using testing::ElementsAre;
using testing::IsEmpty;

void push_frame(LiveQueue& queue, std::uint32_t frame, std::uint8_t layers = 3,
                std::size_t size = 10) {
  for (std::uint8_t i = 0; i < layers; ++i) {
    queue.push(frame, i, layers, layer_message(frame, i, layers, size));
  }
}

std::vector<std::string> take_all(LiveQueue& queue) {
  std::vector<std::string> taken;
  while (const auto message = queue.next()) taken.push_back(brief(*message));
  return taken;
}

TEST(LiveMessage, a_layer_in_pieces_has_the_bytes_of_a_whole_one) {
  LiveLayer layer;
  layer.frame = 3;
  layer.layers = 2;
  layer.sizes = {4, 0, 2};
  const Bytes bytes = {1, 2, 3, 4, 5, 6};
  layer.bytes = bytes;
  const LiveMessage message = layer_message(layer, {{1, 2, 3, 4}, {}, {5, 6}});
  Bytes sent;
  for (const ByteView piece : message.pieces()) sent.insert(sent.end(), piece.begin(), piece.end());
  EXPECT_EQ(sent, write_live_layer(layer));
  EXPECT_EQ(message.size(), sent.size());
}

TEST(LiveQueue, gives_no_messages_about_drops_to_a_publisher) {
  LiveQueue queue({.frames = 1, .tell_drops = false});
  push_frame(queue, 0, 1);
  push_frame(queue, 1, 1);
  EXPECT_EQ(queue.drops(), (LiveDrops{1, 1}));
  EXPECT_THAT(take_all(queue), ElementsAre("1.0"));
  EXPECT_TRUE(queue.empty());
}

TEST(LiveQueue, a_viewer_that_keeps_up_gets_everything_in_order) {
  LiveQueue queue;
  queue.hello(text_message(write_hello(plain_hello())), true);
  push_frame(queue, 0);
  EXPECT_THAT(take_all(queue), ElementsAre("hello", "0.0", "0.1", "0.2"));
  EXPECT_TRUE(queue.empty());
  push_frame(queue, 1);
  push_frame(queue, 2);
  EXPECT_FALSE(queue.empty());
  EXPECT_THAT(take_all(queue), ElementsAre("1.0", "1.1", "1.2", "2.0", "2.1", "2.2"));
  EXPECT_EQ(queue.drops(), LiveDrops{});
}

TEST(LiveQueue, layers_are_delivered_as_they_arrive_to_a_waiting_viewer) {
  LiveQueue queue;
  queue.push(5, 0, 3, layer_message(5, 0));
  EXPECT_THAT(take_all(queue), ElementsAre("5.0"));
  queue.push(5, 1, 3, layer_message(5, 1));
  EXPECT_THAT(take_all(queue), ElementsAre("5.1"));
  queue.push(5, 2, 3, layer_message(5, 2));
  EXPECT_THAT(take_all(queue), ElementsAre("5.2"));
}

TEST(LiveQueue, a_viewer_that_falls_behind_skips_to_the_newest_frame_and_is_told) {
  LiveQueue queue({.frames = 3});
  for (std::uint32_t frame = 0; frame < 3; ++frame) push_frame(queue, frame);
  EXPECT_EQ(queue.drops(), LiveDrops{});
  push_frame(queue, 3);
  // Three frames of three layers were dropped, and the finest layer of the newest frame.
  EXPECT_EQ(queue.drops(), (LiveDrops{3, 10}));
  EXPECT_THAT(take_all(queue), ElementsAre("drops 3 10", "3.0", "3.1"));
}

TEST(LiveQueue, a_frame_whose_base_was_delivered_does_not_count_as_dropped) {
  LiveQueue queue({.frames = 1});
  push_frame(queue, 0);
  EXPECT_EQ(brief(*queue.next()), "0.0");
  push_frame(queue, 1);
  EXPECT_EQ(queue.drops(), (LiveDrops{0, 3}));
}

TEST(LiveQueue, the_newest_base_is_never_dropped_under_any_limits) {
  LiveQueue queue({.frames = 1, .bytes = 0});
  for (std::uint32_t frame = 0; frame < 50; ++frame) {
    push_frame(queue, frame, 3, 1000);
    EXPECT_LE(queue.bytes(), 1000 + kLiveHeaderSize);
  }
  EXPECT_THAT(take_all(queue), Contains("49.0"));
}

TEST(LiveQueue, the_finest_layers_are_dropped_first_to_stay_within_the_bytes) {
  LiveQueue queue({.frames = 4, .bytes = 2500});
  push_frame(queue, 0, 3, 1000);
  EXPECT_THAT(take_all(queue), ElementsAre("drops 0 1", "0.0", "0.1"));
}

TEST(LiveQueue, a_stall_of_any_length_leaves_one_frame_and_a_bounded_queue) {
  LiveQueue queue;
  for (std::uint32_t frame = 0; frame < 1000; ++frame) {
    push_frame(queue, frame, 3, 100);
    ASSERT_LE(queue.bytes(), 4 * 3 * (100 + kLiveHeaderSize));
  }
  const auto taken = take_all(queue);
  EXPECT_EQ(taken.back(), "999.0");
  EXPECT_LE(taken.size(), 5u);
}

TEST(LiveQueue, slow_viewers_get_fewer_layers_of_every_frame_and_later_more_again) {
  LiveQueue queue({.frames = 2});
  // The link carries four messages in the time in which two frames of three layers arrive.
  std::vector<std::string> taken;
  for (std::uint32_t frame = 0; frame < 60; frame += 2) {
    push_frame(queue, frame);
    push_frame(queue, frame + 1);
    for (int i = 0; i < 4; ++i) {
      if (const auto message = queue.next()) taken.push_back(brief(*message));
    }
  }
  int bases = 0;
  for (std::uint32_t frame = 0; frame < 60; ++frame) {
    const std::string base = std::to_string(frame) + ".0";
    bases += std::find(taken.begin(), taken.end(), base) != taken.end() ? 1 : 0;
  }
  EXPECT_GE(bases, 40) << testing::PrintToString(taken);
  // Then the link is fast again.
  for (std::uint32_t frame = 60; frame < 2000; ++frame) {
    push_frame(queue, frame);
    taken = take_all(queue);
  }
  EXPECT_THAT(taken, ElementsAre("1999.0", "1999.1", "1999.2"));
}

TEST(LiveQueue, all_layers_return_within_a_second_after_a_long_stall) {
  LiveQueue queue;
  for (std::uint32_t frame = 0; frame < 300; ++frame) push_frame(queue, frame);
  std::vector<std::string> taken;
  for (std::uint32_t frame = 300; frame < 330; ++frame) {
    taken = take_all(queue);
    push_frame(queue, frame);
  }
  EXPECT_THAT(take_all(queue), ElementsAre("329.0", "329.1", "329.2"));
}

TEST(LiveQueue, layers_of_a_frame_that_began_before_joining_are_skipped) {
  LiveQueue queue;
  queue.push(4, 1, 3, layer_message(4, 1));
  EXPECT_TRUE(queue.empty());
  EXPECT_EQ(queue.drops(), LiveDrops{});
}

TEST(LiveQueue, a_new_session_discards_the_previous_one) {
  LiveQueue queue;
  push_frame(queue, 8);
  queue.hello(text_message(write_hello(plain_hello(2))), true);
  EXPECT_THAT(take_all(queue), ElementsAre("hello"));
  push_frame(queue, 0);
  EXPECT_THAT(take_all(queue), ElementsAre("0.0", "0.1", "0.2"));
}

TEST(LiveQueue, the_end_is_delivered_last_and_never_after_the_publisher_returns) {
  LiveQueue queue;
  push_frame(queue, 8, 1);
  queue.end(text_message(write_end()));
  EXPECT_THAT(take_all(queue), ElementsAre("8.0", "end"));
  queue.end(text_message(write_end()));
  queue.hello(text_message(write_hello(plain_hello())), false);
  EXPECT_THAT(take_all(queue), ElementsAre("hello"));
  EXPECT_THAT(take_all(queue), IsEmpty());
}

}  // namespace
}  // namespace pointreel::live_queue_test
