#include "client/playback/play_order.h"

#include <vector>

#include <gtest/gtest.h>

namespace pointreel::play_order_test {
namespace {

using Frames = std::vector<std::uint32_t>;

Frames from(const PlayOrder& order, std::uint32_t first) {
  Frames frames;
  for (std::uint32_t step = 0; const auto frame = order.after(first, step); ++step) {
    frames.push_back(*frame);
    if (step > 2 * order.count) break;
  }
  return frames;
}

TEST(PlayOrder, stops_at_the_end_or_wraps_in_a_loop) {
  EXPECT_EQ(from({5, false, 1, {}}, 2), (Frames{2, 3, 4}));
  EXPECT_EQ(from({5, true, 1, {}}, 2), (Frames{2, 3, 4, 0, 1}));
  EXPECT_EQ(from({5, false, -1, {}}, 2), (Frames{2, 1, 0}));
  EXPECT_EQ(from({5, true, -1, {}}, 2), (Frames{2, 1, 0, 4, 3}));
}

TEST(PlayOrder, stays_in_the_loop_range_whether_or_not_the_reel_loops) {
  for (const bool loop : {false, true}) {
    EXPECT_EQ(from({9, loop, 1, FrameRange{3, 6}}, 5), (Frames{5, 6, 3, 4}));
    EXPECT_EQ(from({9, loop, -1, FrameRange{3, 6}}, 5), (Frames{5, 4, 3, 6}));
    EXPECT_EQ(from({9, loop, 1, FrameRange{3, 3}}, 3), (Frames{3}));
  }
}

TEST(PlayOrder, enters_the_loop_range_from_before_it) {
  EXPECT_EQ(from({9, false, 1, FrameRange{3, 6}}, 1), (Frames{1, 2, 3, 4, 5, 6}));
  EXPECT_EQ(from({9, false, -1, FrameRange{3, 6}}, 8), (Frames{8, 7, 6, 5, 4, 3}));
}

TEST(PlayOrder, leaves_the_loop_range_alone_beyond_it_until_the_reel_wraps) {
  EXPECT_EQ(from({9, false, 1, FrameRange{3, 6}}, 7), (Frames{7, 8}));
  EXPECT_EQ(from({9, true, 1, FrameRange{3, 6}}, 7), (Frames{7, 8, 0, 1, 2, 3, 4, 5, 6}));
  EXPECT_EQ(from({9, true, -1, FrameRange{3, 6}}, 2), (Frames{2, 1, 0, 8, 7, 6, 5, 4, 3}));
}

TEST(PlayOrder, counts_the_steps_to_every_frame_that_follows_and_to_no_other) {
  std::vector<std::optional<FrameRange>> ranges{std::nullopt};
  for (std::uint32_t first = 0; first < 6; ++first)
    for (std::uint32_t last = first; last < 6; ++last) ranges.emplace_back(FrameRange{first, last});
  for (const auto& range : ranges)
    for (const bool loop : {false, true})
      for (const int direction : {1, -1})
        for (std::uint32_t start = 0; start < 6; ++start) {
          const PlayOrder order{6, loop, direction, range};
          const Frames frames = from(order, start);
          std::vector<std::optional<std::uint32_t>> expected(6);
          for (std::uint32_t step = 0; step < frames.size(); ++step) {
            ASSERT_FALSE(expected[frames[step]]) << "a frame comes twice";
            expected[frames[step]] = step;
          }
          for (std::uint32_t to = 0; to < 6; ++to) EXPECT_EQ(order.steps(start, to), expected[to]);
        }
}

}  // namespace
}  // namespace pointreel::play_order_test
