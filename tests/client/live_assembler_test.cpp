#include "client/source/live_assembler.h"

#include <string>
#include <thread>

#include <gtest/gtest.h>

namespace pointreel::live_assembler_test {
namespace {

using namespace std::chrono_literals;

constexpr auto kLong = std::chrono::milliseconds(60'000);
constexpr auto kAtOnce = std::chrono::milliseconds(0);

LiveHello hello_of(std::uint64_t session) {
  LiveHello hello;
  hello.name = "ball";
  hello.session = session;
  hello.codec = "octree";
  hello.layer_names = {"base", "middle", "full"};
  return hello;
}

class Assembler : public testing::Test {
 protected:
  Assembler() { assembler_.add(hello_of(1)); }

  void layer(std::uint32_t frame, std::uint8_t number, std::uint8_t layers = 3) {
    const Bytes bytes(10u + number, static_cast<std::uint8_t>(frame));
    assembler_.add(LiveLayer{.frame = frame,
                             .layer = number,
                             .layers = layers,
                             .capture_us = 1000u * frame,
                             .points = 5,
                             .sizes = {10u + number, 0, 0},
                             .bytes = bytes},
                   bytes);
  }
  void whole(std::uint32_t frame) {
    for (std::uint8_t i = 0; i < 3; ++i) layer(frame, i);
  }

  LiveAssembler assembler_{std::chrono::hours(1)};
};

TEST_F(Assembler, gives_a_frame_once_all_of_its_layers_have_arrived) {
  layer(7, 0);
  layer(7, 1);
  EXPECT_FALSE(assembler_.next(kAtOnce));
  layer(7, 2);
  const auto frame = assembler_.next(kLong);
  ASSERT_TRUE(frame);
  EXPECT_EQ(frame->number, 7u);
  EXPECT_EQ(frame->capture_us, 7000u);
  EXPECT_EQ(frame->layers_sent, 3u);
  ASSERT_EQ(frame->frame.layers.size(), 3u);
  EXPECT_EQ(frame->frame.layers[1].bytes, Bytes(11, 7));
  EXPECT_EQ(frame->frame.layers[1].sizes.geometry, 11u);
  EXPECT_FALSE(assembler_.next(kAtOnce)) << "a frame is given only once";
}

TEST_F(Assembler, gives_an_incomplete_frame_when_the_next_one_begins) {
  layer(1, 0);
  layer(2, 0);
  const auto frame = assembler_.next(kLong);
  ASSERT_TRUE(frame);
  EXPECT_EQ(frame->number, 1u);
  EXPECT_EQ(frame->frame.layers.size(), 1u);
}

TEST_F(Assembler, skips_to_the_newest_frame_and_counts_the_skipped_ones) {
  for (std::uint32_t i = 0; i < 10; ++i) whole(i);
  EXPECT_EQ(assembler_.next(kLong)->number, 9u);
  const LiveCounts counts = assembler_.counts();
  EXPECT_EQ(counts.frames, 1u);
  EXPECT_EQ(counts.skipped, 9u);
  EXPECT_EQ(counts.bytes, 10u * 33u);
}

TEST(AssemblerInAHurry, gives_the_base_if_the_rest_is_late_and_the_rest_when_it_arrives) {
  LiveAssembler assembler(0ms);
  assembler.add(hello_of(1));
  const Bytes bytes(4);
  const auto layer = [&](std::uint8_t number) {
    assembler.add(LiveLayer{3, number, 2, 0, 1, {4, 0, 0}, bytes}, bytes);
  };
  layer(0);
  EXPECT_EQ(assembler.next(kLong)->frame.layers.size(), 1u);
  EXPECT_FALSE(assembler.next(kAtOnce));
  layer(1);
  const auto again = assembler.next(kLong);
  EXPECT_EQ(again->number, 3u);
  EXPECT_EQ(again->frame.layers.size(), 2u);
  EXPECT_EQ(assembler.counts().frames, 1u);
}

TEST_F(Assembler, ignores_and_counts_layers_out_of_order) {
  layer(5, 1);     // not the base
  layer(5, 0);     // accepted
  layer(5, 2);     // layer 1 is missing
  layer(5, 1, 2);  // of a frame of two layers
  layer(6, 1);     // frame 6 has not begun
  layer(4, 0);     // older
  layer(9, 0, 4);  // more layers than the stream has
  EXPECT_EQ(assembler_.counts().bad, 6u);
  layer(5, 1);
  layer(5, 2);
  EXPECT_EQ(assembler_.next(kLong)->number, 5u);
}

TEST(AssemblerAtFirst, accepts_nothing_before_a_hello) {
  LiveAssembler assembler;
  const Bytes bytes(4);
  assembler.add(LiveLayer{3, 0, 1, 0, 1, {4, 0, 0}, bytes}, bytes);
  EXPECT_EQ(assembler.counts().bad, 1u);
  EXPECT_FALSE(assembler.hello(kAtOnce));
  EXPECT_FALSE(assembler.next(kAtOnce));
}

TEST_F(Assembler, continues_after_a_reconnection) {
  whole(5);
  EXPECT_EQ(assembler_.next(kLong)->number, 5u);
  assembler_.reconnected();
  assembler_.add(hello_of(1));
  whole(5);  // repeated
  EXPECT_FALSE(assembler_.next(kAtOnce));
  whole(6);
  EXPECT_EQ(assembler_.next(kLong)->number, 6u);
  EXPECT_EQ(assembler_.counts().reconnections, 1u);
}

TEST_F(Assembler, completes_a_frame_that_a_reconnection_interrupted) {
  layer(5, 0);
  assembler_.reconnected();
  EXPECT_EQ(assembler_.next(kLong)->frame.layers.size(), 1u);
  whole(5);
  EXPECT_EQ(assembler_.next(kLong)->frame.layers.size(), 3u);
}

TEST_F(Assembler, starts_over_with_a_restarted_publisher) {
  whole(500);
  assembler_.reconnected();
  assembler_.add(hello_of(2));
  EXPECT_FALSE(assembler_.next(kAtOnce)) << "it belongs to the previous publisher";
  whole(0);
  EXPECT_EQ(assembler_.next(kLong)->number, 0u);
}

TEST_F(Assembler, sums_the_drops_of_all_connections) {
  assembler_.set_dropped(3);
  assembler_.set_dropped(5);
  assembler_.reconnected();
  assembler_.set_dropped(2);
  EXPECT_EQ(assembler_.counts().dropped, 7u);
}

TEST_F(Assembler, wakes_its_waiting_reader) {
  std::thread waiting([&] { EXPECT_EQ(assembler_.next(kLong)->number, 1u); });
  whole(1);
  waiting.join();
  std::thread cancelled([&] { EXPECT_FALSE(assembler_.next(kLong)); });
  assembler_.cancel();
  cancelled.join();
}

}  // namespace
}  // namespace pointreel::live_assembler_test
