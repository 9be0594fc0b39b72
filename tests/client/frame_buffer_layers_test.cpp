// Frames with several layers, and scrubbing.

#include <algorithm>
#include <chrono>
#include <compare>
#include <map>
#include <ostream>
#include <set>
#include <vector>

#include <gtest/gtest.h>

#include "tests/client/frame_buffer_test.h"

namespace pointreel::frame_buffer_layers_test {
namespace {

using std::chrono::milliseconds;

std::shared_ptr<const SceneFrame> picture_at(std::uint32_t index, int level) {
  auto frame = std::make_shared<SceneFrame>();
  frame->index = index;
  frame->level = level;
  return frame;
}

TEST(FrameBuffer, finer_levels_are_made_only_after_every_frame_has_one) {
  FrameBuffer buffer(options(100, 2, false));
  buffer.set_level(7);
  const auto answer = [&] {
    const auto request = ask(buffer);
    buffer.deliver(request, picture_at(request.frame, request.level));
    return std::pair{request.frame, request.level};
  };
  EXPECT_EQ(answer(), (std::pair{0u, 7}));
  buffer.seek(0);
  EXPECT_EQ(answer(), (std::pair{1u, 7}));
  EXPECT_EQ(answer(), (std::pair{2u, 7}));
  buffer.set_level(9);
  EXPECT_EQ(buffer.wait(milliseconds(0)), FrameBuffer::State::ready);
  EXPECT_EQ(buffer.wait(milliseconds(0), true), FrameBuffer::State::waiting);
  EXPECT_EQ(answer(), (std::pair{0u, 9}));
  EXPECT_EQ(buffer.wait(milliseconds(0), true), FrameBuffer::State::ready);
  EXPECT_EQ(buffer.best()->level, 9);
  EXPECT_EQ(buffer.held(), 3u);
}

TEST(FrameBuffer, finer_frames_are_kept_when_the_camera_moves_away) {
  FrameBuffer buffer(options(100, 1, false));
  for (int i = 0; i < 2; ++i) {
    const auto request = ask(buffer);
    buffer.deliver(request, picture_at(request.frame, 9));
  }
  EXPECT_EQ(buffer.best()->level, 9);
  buffer.set_level(6);
  EXPECT_EQ(buffer.best()->level, 9);
  buffer.advance(1);
  const auto request = ask(buffer);
  EXPECT_EQ(request.frame, 2u);
  EXPECT_EQ(request.level, 6);
  EXPECT_EQ(buffer.best()->level, 9);
}

TEST(FrameBuffer, an_unavailable_level_is_requested_only_once) {
  FrameBuffer buffer(options(1, 0, false));
  buffer.set_level(7);
  auto request = ask(buffer);
  buffer.deliver(request, picture_at(0, 7));
  buffer.set_level(10);
  request = ask(buffer);
  EXPECT_EQ(request.level, 10);
  buffer.deliver(request, picture_at(0, 7));
  EXPECT_EQ(buffer.wait(milliseconds(0), true), FrameBuffer::State::ready);
  Fetcher fetcher(buffer);
  EXPECT_TRUE(fetcher.waits());
  buffer.close();
  EXPECT_FALSE(fetcher.job());
}

/// Options for three layers that end at levels 7, 9 and 10 and are fetched over a network.
FrameBuffer::Options layered(std::uint32_t frames, std::uint32_t ahead) {
  FrameBuffer::Options layered = options(frames, ahead, false);
  layered.levels = {7, 9, kWholeFrame};
  layered.base_first = true;
  layered.near = 2;
  layered.fetch_ahead = 4;
  layered.store_bytes = 1 << 20;
  return layered;
}

struct Asked {
  std::uint32_t frame, first, last;
  bool operator==(const Asked&) const = default;
};

std::ostream& operator<<(std::ostream& out, const Asked& asked) {
  return out << asked.frame << ':' << asked.first << '-' << asked.last;
}

Asked asked(const FetchRequest& job) { return {job.frame, job.layers.first, job.layers.end}; }

Asked fetch(FrameBuffer& buffer) {
  const auto job = buffer.next_fetch();
  buffer.fetched(*job, layers_of(*job), 1.0);
  return asked(*job);
}

struct FrameLayer {
  std::uint32_t frame, layer;
  auto operator<=>(const FrameLayer&) const = default;
};

std::ostream& operator<<(std::ostream& out, const FrameLayer& one) {
  return out << one.frame << '.' << one.layer;
}

using FrameLayers = std::set<FrameLayer>;

/// Returns all three layers of these frames.
FrameLayers whole(std::uint32_t first, std::uint32_t last) {
  FrameLayers layers;
  for (std::uint32_t frame = first; frame <= last; ++frame)
    for (const std::uint32_t layer : {0u, 1u, 2u}) layers.insert({frame, layer});
  return layers;
}

/// The order in which layers were requested, however they were joined into jobs.
class Turns {
 public:
  void add(const FetchRequest& job) {
    for (std::uint32_t layer = job.layers.first; layer < job.layers.end; ++layer)
      EXPECT_TRUE(turns_.try_emplace({job.frame, layer}, jobs_).second)
          << FrameLayer{job.frame, layer} << " is requested twice";
    ++jobs_;
  }
  int jobs() const { return jobs_; }
  bool include(const FrameLayers& layers) const {
    return std::ranges::all_of(layers, [&](FrameLayer one) { return turns_.contains(one); });
  }
  FrameLayers layers() const {
    FrameLayers layers;
    for (const auto& [layer, turn] : turns_) layers.insert(layer);
    return layers;
  }
  /// The number of the job that brings this layer of the frame, counted from 0. Returns -1 if none
  /// does.
  int of(std::uint32_t frame, std::uint32_t layer) const {
    const auto found = turns_.find({frame, layer});
    return found == turns_.end() ? -1 : found->second;
  }

 private:
  int jobs_ = 0;
  std::map<FrameLayer, int> turns_;
};

/// Requests jobs until these layers are on their way, as many fetching threads would at the same
/// time.
Turns ask_for(FrameBuffer& buffer, const FrameLayers& layers) {
  Turns turns;
  while (!turns.include(layers) && turns.jobs() < 100) turns.add(*buffer.next_fetch());
  return turns;
}

/// The same with a single thread, which gets a job's layers before it asks for the next job.
Turns fetch(FrameBuffer& buffer, const FrameLayers& layers) {
  Turns turns;
  while (!turns.include(layers) && turns.jobs() < 100) {
    const auto job = buffer.next_fetch();
    buffer.fetched(*job, layers_of(*job), 1.0);
    turns.add(*job);
  }
  return turns;
}

TEST(FrameBuffer, the_base_of_the_playhead_comes_first_and_near_frames_before_far_ones) {
  FrameBuffer buffer(layered(100, 1));  // frames 0 and 1 are near; 2 to 4 are fetched too
  const Turns turns = ask_for(buffer, whole(0, 4));
  EXPECT_EQ(turns.layers(), whole(0, 4));
  EXPECT_EQ(turns.of(0, 0), 0) << "the base of the playhead's frame comes first";
  for (const std::uint32_t near : {0u, 1u}) {
    EXPECT_LT(turns.of(near, 0), turns.of(near, 1)) << "a base is fetched alone: " << near;
    for (const std::uint32_t layer : {0u, 1u, 2u})
      EXPECT_LT(turns.of(near, layer), turns.of(2, 0)) << near << ", layer " << layer;
  }
  for (const std::uint32_t ahead : {2u, 3u}) EXPECT_LT(turns.of(ahead, 2), turns.of(ahead + 1, 0));
}

TEST(FrameBuffer, a_frame_that_is_about_to_pass_is_not_refined) {
  FrameBuffer buffer(layered(100, 1));
  buffer.set_pace({4, 1, true, false});
  FrameLayers all_but_the_rest_of_0 = whole(1, 4);
  all_but_the_rest_of_0.insert({0, 0});
  const Turns turns = ask_for(buffer, all_but_the_rest_of_0);
  EXPECT_EQ(turns.layers(), all_but_the_rest_of_0);
  EXPECT_EQ(turns.of(0, 0), 0);
}

TEST(FrameBuffer, nothing_else_is_fetched_before_an_awaited_frame_is_whole) {
  FrameBuffer buffer(layered(100, 2));
  buffer.set_pace({4, 0, true, true});
  const auto base = buffer.next_fetch(), rest = buffer.next_fetch();
  EXPECT_EQ(asked(*base), (Asked{0, 0, 1}));
  EXPECT_EQ(asked(*rest), (Asked{0, 1, 3}));
  Fetcher fetcher(buffer);
  EXPECT_TRUE(fetcher.waits());
  buffer.fetched(*base, layers_of(*base), 1.0);
  buffer.fetched(*rest, layers_of(*rest), 1.0);
  buffer.deliver(*buffer.next_wanted(), picture_at(0, kWholeFrame));
  EXPECT_EQ(fetcher.job()->frame, 1u);
}

TEST(FrameBuffer, only_visible_layers_are_fetched_and_a_closer_view_fetches_only_the_rest) {
  FrameBuffer buffer(layered(100, 0));
  buffer.set_level(8);
  const FrameLayers seen = {{0, 0}, {0, 1}};
  EXPECT_EQ(fetch(buffer, seen).layers(), seen);
  buffer.set_level(10);
  EXPECT_EQ(fetch(buffer), (Asked{0, 2, 3}));
  const auto request = buffer.next_wanted();
  EXPECT_EQ(request->layers, 3u);
  ASSERT_EQ(request->fetched.layers.size(), 3u);
  EXPECT_EQ(request->fetch_ms, 1.0);
}

TEST(FrameBuffer, the_base_is_shown_until_the_rest_arrives) {
  FrameBuffer buffer(layered(100, 0));
  fetch(buffer);
  const auto base = buffer.next_wanted();
  EXPECT_EQ(base->layers, 1u);
  buffer.deliver(*base, picture_at(0, 7));
  EXPECT_EQ(buffer.wait(milliseconds(0)), FrameBuffer::State::ready);
  EXPECT_EQ(buffer.wait(milliseconds(0), true), FrameBuffer::State::waiting);
  EXPECT_EQ(fetch(buffer), (Asked{0, 1, 3}));
  const auto whole = buffer.next_wanted();
  EXPECT_EQ(whole->layers, 3u);
  buffer.deliver(*whole, picture_at(0, kWholeFrame));
  EXPECT_EQ(buffer.wait(milliseconds(0), true), FrameBuffer::State::ready);
  EXPECT_EQ(buffer.best()->level, kWholeFrame);
}

TEST(FrameBuffer, an_awaited_frame_is_prepared_from_its_base_and_from_all_at_once) {
  FrameBuffer::Options options = layered(10, 2);
  options.base_first = false;
  FrameBuffer buffer(options);
  buffer.set_pace({.fetch_ahead = 4, .focus = true, .coarse_first = true});
  fetch(buffer);  // all layers of frame 0
  const auto base = buffer.next_wanted(), rest = buffer.next_wanted();
  EXPECT_EQ(base->layers, 1u);
  EXPECT_EQ(rest->frame, 0u);
  EXPECT_EQ(rest->layers, 3u);
  EXPECT_EQ(base->fetch_ms, 1.0) << "both count the fetch, whichever is shown first";
  EXPECT_EQ(rest->fetch_ms, 1.0);
  buffer.deliver(*base, picture_at(0, 7));
  ASSERT_TRUE(buffer.best());
  EXPECT_EQ(buffer.best()->level, 7);
  buffer.deliver(*rest, picture_at(0, kWholeFrame));
  EXPECT_EQ(buffer.best()->level, kWholeFrame);
  // From then on, frames are decoded only once they are complete.
  buffer.set_pace({.fetch_ahead = 4});
  fetch(buffer);
  EXPECT_EQ(buffer.next_wanted()->layers, 3u);
}

TEST(FrameBuffer, a_coarser_version_does_not_replace_a_finer_one_that_was_ready_first) {
  FrameBuffer buffer(layered(100, 0));
  fetch(buffer);
  const auto base = buffer.next_wanted();
  fetch(buffer);
  buffer.deliver(*buffer.next_wanted(), picture_at(0, kWholeFrame));
  buffer.deliver(*base, picture_at(0, 7));
  EXPECT_EQ(buffer.best()->level, kWholeFrame);
}

TEST(FrameBuffer, a_return_to_fetched_frames_fetches_nothing_again) {
  FrameBuffer buffer(layered(100, 1));
  fetch(buffer, whole(0, 4));
  buffer.seek(50);
  EXPECT_EQ(fetch(buffer), (Asked{50, 0, 1}));
  buffer.seek(1, -1);
  EXPECT_EQ(buffer.next_wanted()->frame, 1u);
  EXPECT_EQ(buffer.next_wanted()->frame, 0u);
}

TEST(FrameBuffer, coded_frames_stay_within_their_budget_of_bytes) {
  FrameBuffer::Options small = layered(1000, 1);
  small.store_bytes = 400;
  FrameBuffer buffer(small);
  for (std::uint32_t frame = 0; frame < 990; frame += 37) {
    buffer.seek(frame);
    for (int i = 0; i < 4; ++i) fetch(buffer);
    EXPECT_LE(buffer.stored_bytes(), 400u);
  }
}

TEST(FrameBuffer, a_frame_does_without_layers_that_cannot_be_fetched) {
  FrameBuffer buffer(layered(100, 0));
  fetch(buffer);
  buffer.deliver(*buffer.next_wanted(), picture_at(0, 7));
  const auto rest = buffer.next_fetch();
  EXPECT_EQ(asked(*rest), (Asked{0, 1, 3}));
  buffer.fetch_failed(*rest);
  const auto middle = buffer.next_fetch();
  EXPECT_EQ(asked(*middle), (Asked{0, 1, 2})) << "one of the two layers may still be available";
  buffer.fetch_failed(*middle);
  EXPECT_EQ(buffer.wait(milliseconds(0), true), FrameBuffer::State::ready);
  EXPECT_EQ(buffer.best()->level, 7);
  EXPECT_EQ(buffer.next_fetch()->frame, 1u);
}

TEST(FrameBuffer, a_frame_does_without_a_layer_that_is_damaged_twice) {
  FrameBuffer buffer(layered(100, 0));
  fetch(buffer);
  buffer.deliver(*buffer.next_wanted(), picture_at(0, 7));
  fetch(buffer);
  EXPECT_TRUE(buffer.broken(*buffer.next_wanted(), 1));
  const auto again = buffer.next_fetch();
  EXPECT_EQ(asked(*again), (Asked{0, 1, 2})) << "the layer after it has already been fetched";
  EXPECT_TRUE(again->fresh);
  buffer.fetched(*again, layers_of(*again), 1.0);
  EXPECT_FALSE(buffer.broken(*buffer.next_wanted(), 1));
  EXPECT_EQ(buffer.wait(milliseconds(0), true), FrameBuffer::State::ready);
  EXPECT_EQ(buffer.best()->level, 7);
}

TEST(FrameBuffer, what_is_damaged_stays_known_where_coded_frames_are_not_kept) {
  FrameBuffer::Options cheap = layered(100, 0);
  cheap.store_bytes = 0;
  cheap.base_first = false;
  FrameBuffer buffer(cheap);
  fetch(buffer);
  EXPECT_TRUE(buffer.broken(*buffer.next_wanted(), 1));
  fetch(buffer);
  EXPECT_FALSE(buffer.broken(*buffer.next_wanted(), 1));
  const auto coarse = buffer.next_wanted();
  EXPECT_EQ(coarse->layers, 1u);
  buffer.deliver(*coarse, picture_at(0, 7));
  EXPECT_EQ(buffer.wait(milliseconds(0), true), FrameBuffer::State::ready);
  EXPECT_EQ(buffer.stored_bytes(), 0u);
}

TEST(FrameBuffer, only_the_chosen_layers_and_attributes_are_fetched) {
  FrameBuffer::Options chosen = layered(100, 0);
  LayerRange choice{0, 1, true, false};
  chosen.choice = [&choice](std::uint32_t, DrawMode, int) { return choice; };
  FrameBuffer buffer(chosen);
  const auto base = buffer.next_fetch();
  EXPECT_EQ(asked(*base), (Asked{0, 0, 1}));
  EXPECT_FALSE(base->layers.normals);
  buffer.fetched(*base, layers_of(*base), 1.0);
  buffer.deliver(*buffer.next_wanted(), picture_at(0, 7));
  EXPECT_EQ(buffer.wait(milliseconds(0), true), FrameBuffer::State::ready);
  choice = {0, 2, true, true};
  buffer.choice_changed();
  EXPECT_EQ(buffer.wait(milliseconds(0), true), FrameBuffer::State::waiting);
  const FrameLayers missing = {{0, 0}, {0, 1}};
  EXPECT_EQ(fetch(buffer, missing).layers(), missing) << "refetch the base for its normals";
  EXPECT_EQ(buffer.next_wanted()->layers, 2u);
}

// Scrubbing.

TEST(FrameBuffer, scrubbing_fetches_only_the_base_under_the_cursor) {
  FrameBuffer::Options options = layered(100, 1);
  options.near = 0;  // as for a reel read from a folder
  FrameBuffer buffer(options);
  buffer.scrub(40);
  EXPECT_EQ(fetch(buffer), (Asked{40, 0, 1}));
  const auto request = buffer.next_wanted();
  EXPECT_EQ(request->layers, 1u);
  buffer.deliver(*request, picture_at(40, 7));
  EXPECT_EQ(buffer.wait(milliseconds(0), true), FrameBuffer::State::ready);
  Fetcher fetcher(buffer);
  EXPECT_TRUE(fetcher.waits());
  buffer.seek(40);
  EXPECT_EQ(fetcher.job()->frame, 40u) << "the frame is refined once the button is released";
}

TEST(FrameBuffer, scrubbing_fetches_bases_around_the_cursor_once_its_own_has_arrived) {
  FrameBuffer buffer(layered(100, 1));
  buffer.scrub(10);
  const FrameLayers around = {{9, 0}, {10, 0}, {11, 0}, {12, 0}};
  const Turns turns = fetch(buffer, around);
  EXPECT_EQ(turns.layers(), around);
  EXPECT_EQ(turns.of(10, 0), 0);
  EXPECT_LT(turns.of(11, 0), turns.of(9, 0)) << "a drag is expected to go forward at first";
  const auto request = buffer.next_wanted();
  EXPECT_EQ(request->frame, 10u);
  buffer.deliver(*request, picture_at(10, 7));
  buffer.scrub(9);
  EXPECT_EQ(buffer.next_wanted()->frame, 9u) << "it has already been fetched";
  const FrameLayers before = {{7, 0}, {8, 0}};
  EXPECT_EQ(fetch(buffer, before).layers(), before) << "the drag goes backward now";
}

TEST(FrameBuffer, scrubbing_reserves_the_link_for_the_base_under_the_cursor) {
  FrameBuffer::Options options = layered(100, 1);
  options.near = 8;
  FrameBuffer buffer(options);
  buffer.scrub(10);
  fetch(buffer);
  std::vector<FetchRequest> beside;
  for (int i = 0; i < 2; ++i) beside.push_back(*buffer.next_fetch());
  EXPECT_EQ(asked(beside[0]), (Asked{11, 0, 1}));
  EXPECT_EQ(asked(beside[1]), (Asked{12, 0, 1}));
  buffer.scrub(12);
  for (const FetchRequest& job : beside)
    EXPECT_FALSE(job.stop.stop_requested()) << "the viewer waits for one of them: " << job.frame;
  Fetcher fetcher(buffer);
  EXPECT_TRUE(fetcher.waits()) << "two jobs are the limit";
  buffer.scrub(30);
  EXPECT_EQ(asked(*fetcher.job()), (Asked{30, 0, 1}));
  for (const FetchRequest& job : beside)
    EXPECT_EQ(job.stop.stop_requested(), job.frame != 12) << "only 12 is kept: " << job.frame;
}

TEST(FrameBuffer, scrubbing_fetches_the_newest_cursor_and_cancels_all_but_the_one_before) {
  FrameBuffer buffer(layered(100, 1));
  const auto playing = buffer.next_fetch();
  buffer.scrub(10);
  const auto first = buffer.next_fetch();
  EXPECT_EQ(asked(*first), (Asked{10, 0, 1}));
  EXPECT_FALSE(first->stop.stop_requested());
  buffer.scrub(20);
  EXPECT_TRUE(playing->stop.stop_requested());
  EXPECT_FALSE(first->stop.stop_requested());
  const auto second = buffer.next_fetch();
  EXPECT_EQ(asked(*second), (Asked{20, 0, 1}));
  buffer.scrub(30);
  EXPECT_TRUE(first->stop.stop_requested());
  EXPECT_FALSE(second->stop.stop_requested());
  EXPECT_EQ(fetch(buffer), (Asked{30, 0, 1}));
}

TEST(FrameBuffer, a_fast_drag_shows_frames_that_it_passed_but_never_goes_back) {
  FrameBuffer buffer(layered(100, 1));
  for (int i = 0; i < 2; ++i) fetch(buffer);
  buffer.deliver(*buffer.next_wanted(), picture(0));
  buffer.scrub(10);
  ASSERT_NE(buffer.best(), nullptr) << "the last picture must stay";
  EXPECT_EQ(buffer.best()->index, 0u);
  fetch(buffer);
  const auto ten = buffer.next_wanted();
  buffer.scrub(20);
  fetch(buffer);
  const auto twenty = buffer.next_wanted();
  buffer.scrub(30);
  buffer.deliver(*twenty, picture(20));
  EXPECT_EQ(buffer.best()->index, 20u);
  buffer.deliver(*ten, picture(10));
  EXPECT_EQ(buffer.best()->index, 20u);
  fetch(buffer);
  buffer.deliver(*buffer.next_wanted(), picture(30));
  EXPECT_EQ(buffer.best()->index, 30u);
}

TEST(FrameBuffer, after_a_drag_no_frame_that_it_passed_is_shown) {
  FrameBuffer buffer(layered(100, 1));
  buffer.scrub(10);
  fetch(buffer);
  const auto ten = buffer.next_wanted();
  buffer.scrub(20);
  buffer.seek(20);
  buffer.deliver(*ten, picture(10));
  EXPECT_EQ(buffer.best(), nullptr);
}

TEST(FrameBuffer, fill_reports_how_many_frames_are_fetched_and_prepared) {
  FrameBuffer buffer(layered(100, 2));
  EXPECT_EQ(buffer.fill().fetched, 0u);
  EXPECT_EQ(buffer.fill().window, 5u);
  EXPECT_EQ(buffer.fill().ahead, 3u);
  fetch(buffer, {{0, 0}});
  EXPECT_EQ(buffer.fill().fetched, 1u);
  fetch(buffer, {{1, 0}});
  EXPECT_EQ(buffer.fill().fetched, 2u);
  buffer.deliver(*buffer.next_wanted(), picture(0));
  EXPECT_EQ(buffer.fill().made, 1u);
  buffer.set_pace({8, 0, true, false});
  EXPECT_EQ(buffer.fill().window, 9u);
}

}  // namespace
}  // namespace pointreel::frame_buffer_layers_test
