#include "tests/client/frame_buffer_test.h"

#include <chrono>
#include <random>
#include <thread>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace pointreel::frame_buffer_test {
namespace {

using std::chrono::milliseconds;
using testing::UnorderedElementsAre;

TEST(FrameBuffer, the_playhead_is_requested_first_and_then_the_frames_ahead) {
  FrameBuffer buffer(options(100, 3, false));
  EXPECT_EQ(serve(buffer, 4), (Frames{0, 1, 2, 3}));
  EXPECT_EQ(buffer.best()->index, 0u);
}

TEST(FrameBuffer, nothing_beyond_the_window_is_requested) {
  FrameBuffer buffer(options(100, 2, false));
  serve(buffer, 3);
  Fetcher fetcher(buffer);
  EXPECT_TRUE(fetcher.waits());
  buffer.advance(1);
  EXPECT_EQ(fetcher.job()->frame, 3u);
}

TEST(FrameBuffer, the_window_wraps_to_the_start_of_a_loop) {
  FrameBuffer buffer(options(10, 3, true));
  buffer.seek(8);
  EXPECT_EQ(serve(buffer, 4), (Frames{8, 9, 0, 1}));
}

TEST(FrameBuffer, the_window_stops_at_the_end_without_a_loop) {
  FrameBuffer buffer(options(10, 3, false));
  buffer.seek(8);
  EXPECT_EQ(serve(buffer, 2), (Frames{8, 9}));
  EXPECT_EQ(buffer.held(), 2u);
}

TEST(FrameBuffer, the_window_extends_backward_for_backward_play) {
  FrameBuffer buffer(options(10, 3, false));
  buffer.seek(5, -1);
  EXPECT_EQ(serve(buffer, 4), (Frames{5, 4, 3, 2}));
  buffer.seek(1, -1);
  EXPECT_EQ(serve(buffer, 2), (Frames{1, 0}));
}

TEST(FrameBuffer, a_reel_shorter_than_the_window_is_prepared_only_once) {
  FrameBuffer buffer(options(3, 8, true));
  EXPECT_THAT(serve(buffer, 3), UnorderedElementsAre(0u, 1u, 2u));
  for (std::uint32_t pass = 0; pass < 5; ++pass)
    for (std::uint32_t f = 0; f < 3; ++f) {
      buffer.advance(f);
      ASSERT_EQ(buffer.best()->index, f);
    }
}

TEST(FrameBuffer, a_seek_requests_the_new_place_first_and_cancels_old_requests) {
  FrameBuffer buffer(options(1000, 4, false));
  const auto old_job = buffer.next_fetch();
  const auto kept_job = buffer.next_fetch();
  buffer.seek(1);
  EXPECT_TRUE(old_job->stop.stop_requested());
  EXPECT_FALSE(kept_job->stop.stop_requested()) << "frame 1 is still wanted";
  buffer.seek(500);
  EXPECT_EQ(buffer.next_fetch()->frame, 500u);
  EXPECT_TRUE(kept_job->stop.stop_requested());
}

TEST(FrameBuffer, a_seek_stops_the_making_of_frames_that_it_leaves_behind) {
  auto keeping = options(1000, 4, false);
  keeping.store_bytes = 1 << 20;
  FrameBuffer buffer(keeping);
  const auto left = ask(buffer), kept = ask(buffer);
  buffer.seek(1);
  EXPECT_TRUE(left.stop.stop_requested());
  EXPECT_FALSE(kept.stop.stop_requested()) << "frame 1 is still wanted";
  buffer.seek(0);
  const auto again = *buffer.next_wanted();
  EXPECT_EQ(again.frame, 0u) << "it is made again before the stopped request is answered";
  buffer.make_stopped(left);
  EXPECT_FALSE(again.stop.stop_requested());
  buffer.seek(0);
  buffer.deliver(again, picture(0));
  EXPECT_EQ(buffer.best()->index, 0u);
  buffer.close();
  EXPECT_TRUE(kept.stop.stop_requested());
}

TEST(FrameBuffer, a_drag_stops_the_making_of_other_frames_but_not_of_those_it_passes) {
  FrameBuffer buffer(options(1000, 4, false));
  const auto shown = ask(buffer), ahead = ask(buffer);
  buffer.scrub(0);
  EXPECT_FALSE(shown.stop.stop_requested());
  EXPECT_TRUE(ahead.stop.stop_requested());
  buffer.scrub(500);
  const auto passed = ask(buffer);
  EXPECT_EQ(passed.frame, 500u);
  buffer.scrub(600);
  EXPECT_FALSE(passed.stop.stop_requested());
}

TEST(FrameBuffer, a_seek_drops_frames_outside_the_new_window) {
  FrameBuffer buffer(options(1000, 4, false));
  serve(buffer, 2);
  const auto old_request = ask(buffer);
  buffer.seek(500);
  EXPECT_EQ(buffer.best(), nullptr);
  buffer.deliver(old_request, picture(old_request.frame));
  EXPECT_EQ(buffer.best(), nullptr);
  EXPECT_EQ(buffer.held(), 0u);
}

TEST(FrameBuffer, a_seek_keeps_frames_inside_the_new_window) {
  FrameBuffer buffer(options(1000, 4, false));
  serve(buffer, 2);
  const auto request = ask(buffer);  // frame 2
  buffer.seek(2);
  buffer.deliver(request, picture(2));
  EXPECT_EQ(buffer.best()->index, 2u);
}

TEST(FrameBuffer, late_frames_are_shown_but_never_older_ones_after_newer_ones) {
  FrameBuffer buffer(options(1000, 4, false));
  const auto first = ask(buffer);
  const auto second = ask(buffer);
  buffer.advance(30);
  buffer.deliver(second, picture(1));
  EXPECT_EQ(buffer.best()->index, 1u);
  buffer.deliver(first, picture(0));
  EXPECT_EQ(buffer.best()->index, 1u);
}

TEST(FrameBuffer, the_last_frame_is_held_while_the_next_one_is_missing) {
  FrameBuffer buffer(options(1000, 4, false));
  serve(buffer, 3);
  buffer.advance(10);
  EXPECT_EQ(buffer.best()->index, 2u);
}

TEST(FrameBuffer, the_last_frame_is_held_across_the_end_of_a_loop) {
  FrameBuffer buffer(options(10, 2, true));
  buffer.seek(7);
  serve(buffer, 3);
  buffer.advance(9);
  buffer.advance(0);
  EXPECT_EQ(buffer.best()->index, 9u);
  buffer.advance(1);
  EXPECT_EQ(buffer.best()->index, 9u);
  EXPECT_EQ(serve(buffer, 1), (Frames{1}));
  EXPECT_EQ(buffer.best()->index, 1u);
}

TEST(FrameBuffer, playback_goes_on_past_a_frame_that_cannot_be_fetched) {
  FrameBuffer buffer(options(100, 2, false));
  serve(buffer, 1);
  buffer.fetch_failed(*buffer.next_fetch());
  EXPECT_EQ(buffer.next_fetch()->frame, 2u);
  buffer.advance(1);
  EXPECT_EQ(buffer.wait(milliseconds(0)), FrameBuffer::State::failed);
  EXPECT_EQ(buffer.best()->index, 0u) << "the last picture must stay";
}

TEST(FrameBuffer, a_failed_frame_is_requested_again_when_the_playhead_returns) {
  FrameBuffer buffer(options(100, 1, false));
  buffer.fetch_failed(*buffer.next_fetch());
  EXPECT_EQ(buffer.wait(milliseconds(0)), FrameBuffer::State::failed);
  buffer.seek(50);
  buffer.seek(0);
  EXPECT_EQ(buffer.next_fetch()->frame, 0u);
}

TEST(FrameBuffer, a_short_loop_requests_a_failed_frame_again_on_the_next_round) {
  FrameBuffer buffer(options(3, 2, true));
  EXPECT_EQ(serve(buffer, 1), (Frames{0}));
  buffer.fetch_failed(*buffer.next_fetch());
  EXPECT_EQ(serve(buffer, 1), (Frames{2}));
  buffer.advance(1);
  EXPECT_EQ(buffer.wait(milliseconds(0)), FrameBuffer::State::failed) << "not tried again at once";
  buffer.advance(2);
  EXPECT_EQ(serve(buffer, 1), (Frames{1}));
  buffer.advance(1);
  EXPECT_EQ(buffer.wait(milliseconds(0)), FrameBuffer::State::ready);
}

TEST(FrameBuffer, a_jump_to_a_failed_frame_nearby_requests_it_again) {
  FrameBuffer buffer(options(100, 2, false));
  EXPECT_EQ(serve(buffer, 1), (Frames{0}));
  buffer.fetch_failed(*buffer.next_fetch());
  buffer.seek(1);
  EXPECT_EQ(buffer.wait(milliseconds(0)), FrameBuffer::State::waiting);
  EXPECT_EQ(buffer.next_fetch()->frame, 1u);
}

TEST(FrameBuffer, a_stopped_fetch_is_requested_again) {
  FrameBuffer buffer(options(100, 2, false));
  const auto job = buffer.next_fetch();
  buffer.fetch_stopped(*job);
  EXPECT_EQ(buffer.next_fetch()->frame, 0u);
}

TEST(FrameBuffer, a_damaged_frame_is_fetched_once_more_and_then_given_up) {
  FrameBuffer buffer(options(100, 2, false));
  const auto first = ask(buffer);
  EXPECT_TRUE(buffer.broken(first, 0));
  EXPECT_EQ(buffer.wait(milliseconds(0)), FrameBuffer::State::waiting);
  const auto job = buffer.next_fetch();
  EXPECT_EQ(job->frame, 0u);
  EXPECT_TRUE(job->fresh);
  buffer.fetched(*job, layers_of(*job), 1.0);
  EXPECT_FALSE(buffer.broken(*buffer.next_wanted(), 0));
  EXPECT_EQ(buffer.wait(milliseconds(0)), FrameBuffer::State::failed);
  EXPECT_EQ(buffer.next_fetch()->frame, 1u);
}

TEST(FrameBuffer, a_change_of_mode_drops_prepared_frames_and_keeps_fetched_ones) {
  FrameBuffer buffer(options(100, 2, false));
  serve(buffer, 1);
  const auto old_request = ask(buffer);
  buffer.make_again(DrawMode::voxel);
  buffer.make_again(DrawMode::surfel);
  EXPECT_EQ(buffer.best(), nullptr);
  EXPECT_EQ(ask(buffer).frame, 0u);
  EXPECT_EQ(buffer.next_wanted()->frame, 1u) << "its fetched layers are kept";
  buffer.deliver(old_request, picture(1));
  EXPECT_EQ(buffer.held(), 0u);
}

/// Room for this many frames outside the window.
FrameBuffer::Options options_with_cache(std::uint32_t frames, std::uint32_t ahead, bool loop,
                                        std::uint32_t kept) {
  FrameBuffer::Options with_cache = options(frames, ahead, loop);
  with_cache.cache_bytes = kept * memory_of(*picture(0));
  return with_cache;
}

/// Plays a round, beginning where the buffer is, and returns the frames that had to be made.
Frames play_round(FrameBuffer& buffer, std::uint32_t frames) {
  Frames made;
  for (std::uint32_t frame = 0; frame < frames; ++frame) {
    buffer.advance(frame);
    if (buffer.wait(milliseconds(0)) == FrameBuffer::State::waiting)
      for (const std::uint32_t one : serve(buffer, 1)) made.push_back(one);
    EXPECT_EQ(buffer.best()->index, frame);
  }
  return made;
}

TEST(FrameBuffer, a_loop_that_fits_the_cache_is_made_once) {
  FrameBuffer buffer(options_with_cache(10, 0, true, 9));
  EXPECT_EQ(play_round(buffer, 10).size(), 10u);
  EXPECT_EQ(buffer.reused(), 0u);
  EXPECT_EQ(play_round(buffer, 10), Frames{});
  EXPECT_EQ(buffer.reused(), 10u);
  EXPECT_EQ(buffer.held(), 10u + 1u) << "and the one that was passed";
  Fetcher fetcher(buffer);
  EXPECT_TRUE(fetcher.waits());
  buffer.close();
  EXPECT_FALSE(fetcher.job());
}

TEST(FrameBuffer, of_a_loop_beyond_the_cache_the_frames_that_come_next_are_kept) {
  FrameBuffer buffer(options_with_cache(10, 0, true, 4));
  EXPECT_EQ(play_round(buffer, 10).size(), 10u);
  // When 0 came into the window, there was room for 9 besides 1 to 3.
  EXPECT_EQ(play_round(buffer, 10), (Frames{4, 5, 6, 7, 8}));
  EXPECT_EQ(buffer.reused(), 5u);
}

TEST(FrameBuffer, backward_the_cache_keeps_what_comes_next_in_that_direction) {
  FrameBuffer buffer(options_with_cache(10, 0, true, 2));
  for (std::uint32_t frame = 0; frame < 3; ++frame) {
    buffer.advance(frame);
    serve(buffer, 1);
  }
  buffer.advance(1, -1);  // 0 comes next, and 2 comes last
  buffer.advance(9, -1);
  EXPECT_EQ(serve(buffer, 1), (Frames{9}));
  buffer.advance(8, -1);
  EXPECT_EQ(serve(buffer, 1), (Frames{8}));
  buffer.advance(2, -1);
  EXPECT_EQ(buffer.wait(milliseconds(0)), FrameBuffer::State::ready);
  buffer.advance(1, -1);
  EXPECT_EQ(buffer.wait(milliseconds(0)), FrameBuffer::State::ready);
}

TEST(FrameBuffer, dragging_back_shows_kept_frames_at_once) {
  FrameBuffer buffer(options_with_cache(100, 0, false, 20));
  EXPECT_EQ(play_round(buffer, 10).size(), 10u);
  for (const std::uint32_t frame : {8u, 3u, 6u}) {
    buffer.scrub(frame);
    EXPECT_EQ(buffer.wait(milliseconds(0), true), FrameBuffer::State::ready);
    EXPECT_EQ(buffer.best()->index, frame);
  }
}

TEST(FrameBuffer, a_jump_shows_kept_frames_at_once_but_no_others_in_their_place) {
  FrameBuffer buffer(options_with_cache(100, 0, false, 20));
  EXPECT_EQ(play_round(buffer, 10).size(), 10u);
  buffer.seek(4);
  EXPECT_EQ(buffer.best()->index, 4u);
  buffer.seek(50);
  EXPECT_EQ(buffer.best(), nullptr);
}

TEST(FrameBuffer, kept_frames_are_made_again_for_another_mode_or_a_finer_level) {
  FrameBuffer buffer(options_with_cache(10, 0, true, 9));
  buffer.set_level(5);
  const auto serve_level = [&](int level) {
    const auto request = ask(buffer);
    auto frame = std::make_shared<SceneFrame>(*picture(request.frame));
    frame->level = level;
    buffer.deliver(request, frame);
    return request.frame;
  };
  EXPECT_EQ(serve_level(5), 0u);
  buffer.advance(1);
  EXPECT_EQ(serve_level(5), 1u);
  buffer.set_level(4);
  buffer.advance(0);
  EXPECT_EQ(buffer.wait(milliseconds(0), true), FrameBuffer::State::ready) << "fine enough";
  buffer.set_level(6);
  EXPECT_EQ(buffer.wait(milliseconds(0)), FrameBuffer::State::ready) << "until it is made again";
  EXPECT_EQ(buffer.wait(milliseconds(0), true), FrameBuffer::State::waiting);
  EXPECT_EQ(serve_level(6), 0u);
  buffer.make_again(DrawMode::voxel);
  EXPECT_EQ(buffer.held(), 0u);
}

TEST(FrameBuffer, a_frame_that_comes_too_late_is_kept_for_the_next_round) {
  FrameBuffer buffer(options_with_cache(10, 0, true, 9));
  const auto late = ask(buffer);
  buffer.advance(5);
  EXPECT_EQ(serve(buffer, 1), (Frames{5}));
  buffer.deliver(late, picture(0));
  EXPECT_EQ(buffer.best()->index, 5u);
  buffer.advance(0);
  EXPECT_EQ(buffer.best()->index, 0u);
  EXPECT_EQ(buffer.wait(milliseconds(0)), FrameBuffer::State::ready);
}

TEST(FrameBuffer, switching_the_loop_off_drops_frames_prepared_beyond_the_end) {
  FrameBuffer buffer(options(10, 3, true));
  buffer.seek(8);
  const auto eight = ask(buffer);
  serve(buffer, 3);  // 9, 0, 1
  buffer.set_loop(false);
  EXPECT_EQ(buffer.held(), 1u);
  EXPECT_EQ(buffer.best(), nullptr);
  buffer.deliver(eight, picture(8));
  EXPECT_EQ(buffer.best()->index, 8u);
}

TEST(FrameBuffer, closing_ends_the_waits_of_workers_and_of_the_player) {
  FrameBuffer buffer(options(1, 0, true));
  serve(buffer, 1);
  std::thread fetcher([&] { EXPECT_FALSE(buffer.next_fetch()); });
  std::thread worker([&] { EXPECT_FALSE(buffer.next_wanted()); });
  FrameBuffer starved(options(1, 0, true));
  std::thread player(
      [&] { EXPECT_EQ(starved.wait(milliseconds(60'000)), FrameBuffer::State::closed); });
  buffer.close();
  starved.close();
  fetcher.join();
  worker.join();
  player.join();
}

TEST(FrameBuffer, random_seeks_never_show_a_wrong_frame_or_exceed_the_bounds) {
  constexpr std::uint32_t kFrames = 50, kAhead = 5;
  FrameBuffer::Options random_options = options(kFrames, kAhead, true);
  random_options.levels = {7, 9, kWholeFrame};
  random_options.base_first = true;
  random_options.fetch_ahead = 12;
  random_options.near = 3;
  random_options.store_bytes = 300;
  FrameBuffer buffer(random_options);
  // Now and then a worker takes a while, so that results overtake each other and arrive after
  // jumps.
  const auto work = [](std::mt19937& random) {
    if (random() % 4 == 0) work_for(std::chrono::microseconds(random() % 300));
  };
  std::vector<std::thread> workers;
  for (int t = 0; t < 3; ++t) {
    workers.emplace_back([&, t] {
      std::mt19937 random(static_cast<unsigned>(t));
      while (const auto job = buffer.next_fetch()) {
        work(random);
        if (job->stop.stop_requested())
          buffer.fetch_stopped(*job);
        else if (random() % 10 == 0)
          buffer.fetch_failed(*job);
        else
          buffer.fetched(*job, layers_of(*job), 0.1);
      }
    });
    workers.emplace_back([&, t] {
      std::mt19937 random(static_cast<unsigned>(t + 100));
      while (const auto request = buffer.next_wanted()) {
        work(random);
        if (random() % 10 == 0)
          buffer.broken(*request, static_cast<std::uint32_t>(random()) % request->layers);
        else
          buffer.deliver(*request, picture(request->frame));
      }
    });
  }
  std::mt19937 random(99);
  std::uint32_t playhead = 0;
  for (int i = 0; i < 3000; ++i) {
    const bool jump = random() % 10 == 0, scrub = random() % 20 == 0;
    const bool back = i / 500 % 2 == 1;
    playhead = jump || scrub ? static_cast<std::uint32_t>(random() % kFrames)
                             : (playhead + (back ? kFrames - 1 : 1)) % kFrames;
    if (scrub)
      buffer.scrub(playhead);
    else if (jump)
      buffer.seek(playhead, back ? -1 : 1);
    else
      buffer.advance(playhead, back ? -1 : 1);
    if (i % 3 == 0) {
      const auto state = buffer.wait(milliseconds(60'000));
      ASSERT_NE(state, FrameBuffer::State::waiting);
      if (state == FrameBuffer::State::ready) {
        ASSERT_EQ(buffer.best()->index, playhead);
      }
    }
    ASSERT_LE(buffer.held(), kAhead + 2);
  }
  buffer.close();
  for (std::thread& worker : workers) worker.join();
}

TEST(FrameBuffer, backward_play_requests_and_holds_frames_in_its_own_direction) {
  FrameBuffer buffer(options(10, 3, true));
  buffer.seek(1, -1);
  EXPECT_EQ(serve(buffer, 4), (Frames{1, 0, 9, 8}));
  buffer.advance(0, -1);
  buffer.advance(9, -1);
  EXPECT_EQ(buffer.best()->index, 9u);
  buffer.advance(7, -1);
  EXPECT_EQ(buffer.best()->index, 8u) << "the most recent frame in the direction of play";
  EXPECT_EQ(serve(buffer, 1), (Frames{7}));
}

TEST(FrameBuffer, reversing_does_not_show_frames_that_were_still_ahead) {
  FrameBuffer buffer(options(100, 3, false));
  buffer.seek(50);
  serve(buffer, 4);  // 50 to 53
  buffer.advance(51);
  buffer.advance(50, -1);
  EXPECT_NE(buffer.best()->index, 53u);
  EXPECT_LE(buffer.best()->index, 51u);
}

TEST(FrameBuffer, near_the_end_of_a_loop_range_its_beginning_is_requested) {
  FrameBuffer buffer(options(100, 3, false));
  buffer.set_loop_range(FrameRange{20, 29});
  buffer.seek(28);
  EXPECT_EQ(serve(buffer, 4), (Frames{28, 29, 20, 21}));
  buffer.advance(20);
  EXPECT_EQ(buffer.best()->index, 20u);
  EXPECT_EQ(serve(buffer, 2), (Frames{22, 23}));
  buffer.seek(30);
  EXPECT_EQ(serve(buffer, 4), (Frames{30, 31, 32, 33}));
}

TEST(FrameBuffer, a_loop_range_shorter_than_the_window_is_kept_whole) {
  FrameBuffer buffer(options(100, 8, false));
  buffer.set_loop_range(FrameRange{20, 22});
  buffer.seek(21);
  EXPECT_THAT(serve(buffer, 3), UnorderedElementsAre(20u, 21u, 22u));
  for (std::uint32_t pass = 0; pass < 3; ++pass)
    for (const std::uint32_t frame : {22u, 20u, 21u}) {
      buffer.advance(frame);
      ASSERT_EQ(buffer.best()->index, frame);
    }
}

TEST(FrameBuffer, buffered_reports_fetched_and_prepared_frames) {
  FrameBuffer::Options kept = options(100, 2, false);
  kept.store_bytes = 1000;
  kept.fetch_ahead = 4;
  FrameBuffer buffer(kept);
  EXPECT_TRUE(buffer.buffered().empty());
  for (int i = 0; i < 5; ++i) {
    const auto job = buffer.next_fetch();
    buffer.fetched(*job, layers_of(*job), 1.0);
  }
  EXPECT_EQ(buffer.buffered(), (std::vector<BufferedRange>{{0, 4, 1}}));
  buffer.seek(50);
  serve(buffer, 1);
  EXPECT_EQ(buffer.buffered(), (std::vector<BufferedRange>{{0, 4, 1}, {50, 50, 1}}));
}

TEST(FrameBuffer, buffered_reports_prepared_frames_whose_bytes_are_gone) {
  FrameBuffer buffer(options(100, 2, false));
  serve(buffer, 3);
  EXPECT_EQ(buffer.stored_bytes(), 0u);
  EXPECT_EQ(buffer.buffered(), (std::vector<BufferedRange>{{0, 2, 1}}));
}

TEST(FrameBuffer, frames_prepared_with_old_settings_are_shown_until_new_ones_are_ready) {
  FrameBuffer buffer(options(100, 0, false));
  const auto old = ask(buffer);
  buffer.make_again(DrawMode::surfel);
  EXPECT_EQ(buffer.best(), nullptr);
  buffer.deliver(old, picture(0));
  const auto before = buffer.best();
  ASSERT_TRUE(before);
  buffer.deliver(*buffer.next_wanted(), picture(0));
  EXPECT_NE(buffer.best(), before);
}

TEST(FrameBuffer, the_newest_passed_frame_is_held_even_if_the_window_covers_the_loop_range) {
  FrameBuffer buffer(options(100, 8, false));
  buffer.set_loop_range(FrameRange{20, 22});
  buffer.seek(19);
  EXPECT_THAT(serve(buffer, 3), UnorderedElementsAre(19u, 20u, 21u));
  for (const std::uint32_t frame : {20u, 21u, 22u}) buffer.advance(frame);
  EXPECT_EQ(buffer.best()->index, 21u) << "frame 22 is not ready yet";
}

}  // namespace
}  // namespace pointreel::frame_buffer_test
