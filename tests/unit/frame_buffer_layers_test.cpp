// Frames of several layers, and the time dragged.

#include <chrono>
#include <ostream>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "tests/unit/frame_buffer_test.h"

namespace pointreel {
namespace {

using std::chrono::milliseconds;

std::shared_ptr<const SceneFrame> picture_at(std::uint32_t index, int level) {
  auto frame = std::make_shared<SceneFrame>();
  frame->index = index;
  frame->level = level;
  return frame;
}

TEST(FrameBuffer, AsksAgainForFramesThatLackALevelOnlyWhenNoneIsMissing) {
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

TEST(FrameBuffer, KeepsWhatIsFinerWhenTheCameraMovesAway) {
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

TEST(FrameBuffer, AsksForALevelThatCannotBeHadOnlyOnce) {
  FrameBuffer buffer(options(1, 0, false));
  buffer.set_level(7);
  auto request = ask(buffer);
  buffer.deliver(request, picture_at(0, 7));
  buffer.set_level(10);
  request = ask(buffer);
  EXPECT_EQ(request.level, 10);
  buffer.deliver(request, picture_at(0, 7));
  EXPECT_EQ(buffer.wait(milliseconds(0), true), FrameBuffer::State::ready);
  std::thread closer([&] {
    std::this_thread::sleep_for(milliseconds(5));
    buffer.close();
  });
  EXPECT_FALSE(buffer.next_fetch());
  closer.join();
}

/// Three layers down to levels 7, 9 and 10, over a network.
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

Asked asked(const FetchJob& job) { return {job.frame, job.first, job.last}; }

Asked fetch(FrameBuffer& buffer) {
  const auto job = buffer.next_fetch();
  buffer.fetched(*job, layers_of(*job), 1.0);
  return asked(*job);
}

TEST(FrameBuffer, AsksForBasesOfWhatIsNearThenForTheirRestsThenForWhatIsFurtherAhead) {
  FrameBuffer buffer(layered(100, 1));
  std::vector<Asked> jobs;
  for (int i = 0; i < 7; ++i) jobs.push_back(asked(*buffer.next_fetch()));
  EXPECT_EQ(jobs,
            (std::vector<Asked>{
                {0, 0, 1}, {0, 1, 3}, {1, 0, 1}, {1, 1, 3}, {2, 0, 3}, {3, 0, 3}, {4, 0, 3}}));
}

TEST(FrameBuffer, DoesNotRefineWhatIsAboutToPass) {
  FrameBuffer buffer(layered(100, 1));
  buffer.set_pace({4, 1, true, false});
  std::vector<Asked> jobs;
  for (int i = 0; i < 3; ++i) jobs.push_back(asked(*buffer.next_fetch()));
  EXPECT_EQ(jobs, (std::vector<Asked>{{0, 0, 1}, {1, 0, 1}, {1, 1, 3}}));
}

TEST(FrameBuffer, DoesNothingElseBeforeTheFrameThatIsWaitedForIsWhole) {
  FrameBuffer buffer(layered(100, 2));
  buffer.set_pace({4, 0, true, true});
  const auto base = buffer.next_fetch(), rest = buffer.next_fetch();
  EXPECT_EQ(asked(*base), (Asked{0, 0, 1}));
  EXPECT_EQ(asked(*rest), (Asked{0, 1, 3}));
  std::atomic<bool> asked_more{false};
  std::thread fetcher([&] {
    buffer.next_fetch();
    asked_more = true;
  });
  std::this_thread::sleep_for(milliseconds(10));
  EXPECT_FALSE(asked_more);
  buffer.fetched(*base, layers_of(*base), 1.0);
  buffer.fetched(*rest, layers_of(*rest), 1.0);
  buffer.deliver(*buffer.next_wanted(), picture_at(0, kWholeFrame));
  fetcher.join();
  EXPECT_TRUE(asked_more);
}

TEST(FrameBuffer, FetchesOnlyTheLayersThatAreSeenAndRefinesWithTheOthersAlone) {
  FrameBuffer buffer(layered(100, 0));
  buffer.set_level(8);
  EXPECT_EQ(fetch(buffer), (Asked{0, 0, 1}));
  EXPECT_EQ(fetch(buffer), (Asked{0, 1, 2}));
  buffer.set_level(10);
  EXPECT_EQ(fetch(buffer), (Asked{0, 2, 3}));
  const auto request = buffer.next_wanted();
  EXPECT_EQ(request->layers, 3u);
  ASSERT_EQ(request->fetched.layers.size(), 3u);
  EXPECT_EQ(request->fetch_ms, 1.0);
}

TEST(FrameBuffer, ShowsTheBaseUntilTheRestIsThere) {
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

TEST(FrameBuffer, MakesTheFirstFrameOfItsBaseFirstAndOfAllBesideIt) {
  FrameBuffer::Options options = layered(10, 2);
  options.base_first = false;
  FrameBuffer buffer(options);
  buffer.set_pace({.fetch_ahead = 4, .focus = true, .coarse_first = true});
  fetch(buffer);  // all of 0
  const auto base = buffer.next_wanted(), rest = buffer.next_wanted();
  EXPECT_EQ(base->layers, 1u);
  EXPECT_EQ(rest->frame, 0u);
  EXPECT_EQ(rest->layers, 3u);
  EXPECT_EQ(base->fetch_ms, 1.0) << "whichever is shown first";
  EXPECT_EQ(rest->fetch_ms, 1.0);
  buffer.deliver(*base, picture_at(0, 7));
  ASSERT_TRUE(buffer.best());
  EXPECT_EQ(buffer.best()->level, 7);
  buffer.deliver(*rest, picture_at(0, kWholeFrame));
  EXPECT_EQ(buffer.best()->level, kWholeFrame);
  // From then on frames are made whole.
  buffer.set_pace({.fetch_ahead = 4});
  fetch(buffer);
  EXPECT_EQ(buffer.next_wanted()->layers, 3u);
}

TEST(FrameBuffer, KeepsTheFinerPictureWhenTheCoarserOneIsReadyAfterIt) {
  FrameBuffer buffer(layered(100, 0));
  fetch(buffer);
  const auto base = buffer.next_wanted();
  fetch(buffer);
  buffer.deliver(*buffer.next_wanted(), picture_at(0, kWholeFrame));
  buffer.deliver(*base, picture_at(0, 7));
  EXPECT_EQ(buffer.best()->level, kWholeFrame);
}

TEST(FrameBuffer, FetchesNothingTwiceForWhoComesBack) {
  FrameBuffer buffer(layered(100, 1));
  for (int i = 0; i < 7; ++i) fetch(buffer);  // frames 0 to 4, whole
  buffer.seek(50);
  EXPECT_EQ(fetch(buffer), (Asked{50, 0, 1}));
  buffer.seek(1, -1);
  EXPECT_EQ(buffer.next_wanted()->frame, 1u);
  EXPECT_EQ(buffer.next_wanted()->frame, 0u);
}

TEST(FrameBuffer, KeepsNoMoreCodedFramesThanItIsTold) {
  FrameBuffer::Options small = layered(1000, 1);
  small.store_bytes = 400;
  FrameBuffer buffer(small);
  for (std::uint32_t frame = 0; frame < 990; frame += 37) {
    buffer.seek(frame);
    for (int i = 0; i < 4; ++i) fetch(buffer);
    EXPECT_LE(buffer.stored_bytes(), 400u);
  }
}

TEST(FrameBuffer, DoesWithCoarserLayersWhereFinerOnesCannotBeHad) {
  FrameBuffer buffer(layered(100, 0));
  fetch(buffer);
  buffer.deliver(*buffer.next_wanted(), picture_at(0, 7));
  const auto rest = buffer.next_fetch();
  EXPECT_EQ(asked(*rest), (Asked{0, 1, 3}));
  buffer.fetch_failed(*rest);
  const auto middle = buffer.next_fetch();
  EXPECT_EQ(asked(*middle), (Asked{0, 1, 2})) << "one of the two may still be there";
  buffer.fetch_failed(*middle);
  EXPECT_EQ(buffer.wait(milliseconds(0), true), FrameBuffer::State::ready);
  EXPECT_EQ(buffer.best()->level, 7);
  EXPECT_EQ(buffer.next_fetch()->frame, 1u);
}

TEST(FrameBuffer, DoesWithCoarserLayersWhereFinerOnesAreBrokenTwice) {
  FrameBuffer buffer(layered(100, 0));
  fetch(buffer);
  buffer.deliver(*buffer.next_wanted(), picture_at(0, 7));
  fetch(buffer);
  EXPECT_TRUE(buffer.broken(*buffer.next_wanted(), 1));
  const auto again = buffer.next_fetch();
  EXPECT_EQ(asked(*again), (Asked{0, 1, 2})) << "the layer after it is there";
  EXPECT_TRUE(again->fresh);
  buffer.fetched(*again, layers_of(*again), 1.0);
  EXPECT_FALSE(buffer.broken(*buffer.next_wanted(), 1));
  EXPECT_EQ(buffer.wait(milliseconds(0), true), FrameBuffer::State::ready);
  EXPECT_EQ(buffer.best()->level, 7);
}

TEST(FrameBuffer, TakesTheLayersThatAreChosen) {
  FrameBuffer::Options chosen = layered(100, 0);
  LayerSet choice{1, true, false};
  chosen.choice = [&choice](std::uint32_t, DrawMode, int) { return choice; };
  FrameBuffer buffer(chosen);
  const auto base = buffer.next_fetch();
  EXPECT_EQ(asked(*base), (Asked{0, 0, 1}));
  EXPECT_FALSE(base->normals);
  buffer.fetched(*base, layers_of(*base), 1.0);
  buffer.deliver(*buffer.next_wanted(), picture_at(0, 7));
  EXPECT_EQ(buffer.wait(milliseconds(0), true), FrameBuffer::State::ready);
  choice = {2, true, true};
  buffer.choice_changed();
  EXPECT_EQ(buffer.wait(milliseconds(0), true), FrameBuffer::State::waiting);
  EXPECT_EQ(fetch(buffer), (Asked{0, 0, 1})) << "for its normals";
  EXPECT_EQ(fetch(buffer), (Asked{0, 1, 2}));
  EXPECT_EQ(buffer.next_wanted()->layers, 2u);
}

// Scrubbing.

TEST(FrameBuffer, AsksForTheBaseUnderTheCursorAloneWhileScrubbing) {
  FrameBuffer::Options options = layered(100, 1);
  options.near = 0;  // as of what is read from a folder
  FrameBuffer buffer(options);
  buffer.scrub(40);
  EXPECT_EQ(fetch(buffer), (Asked{40, 0, 1}));
  const auto request = buffer.next_wanted();
  EXPECT_EQ(request->layers, 1u);
  buffer.deliver(*request, picture_at(40, 7));
  EXPECT_EQ(buffer.wait(milliseconds(0), true), FrameBuffer::State::ready);
  std::atomic<bool> asked_more{false};
  std::thread fetcher([&] {
    if (const auto job = buffer.next_fetch()) asked_more = job->frame == 40;
  });
  std::this_thread::sleep_for(milliseconds(10));
  EXPECT_FALSE(asked_more);
  buffer.seek(40);
  fetcher.join();
  EXPECT_TRUE(asked_more) << "released, it is refined";
}

TEST(FrameBuffer, AsksForTheBasesBesideTheCursorOnceItsOwnIsThere) {
  FrameBuffer buffer(layered(100, 1));
  const auto next = [&](int count) {
    std::vector<Asked> jobs;
    for (int i = 0; i < count; ++i) jobs.push_back(fetch(buffer));
    return jobs;
  };
  buffer.scrub(10);
  EXPECT_EQ(next(4), (std::vector<Asked>{{10, 0, 1}, {11, 0, 1}, {12, 0, 1}, {9, 0, 1}}));
  const auto request = buffer.next_wanted();
  EXPECT_EQ(request->frame, 10u);
  buffer.deliver(*request, picture_at(10, 7));
  buffer.scrub(9);
  EXPECT_EQ(buffer.next_wanted()->frame, 9u) << "it is there already";
  EXPECT_EQ(next(2), (std::vector<Asked>{{8, 0, 1}, {7, 0, 1}})) << "where it goes";
}

TEST(FrameBuffer, LeavesTheLinkToTheBaseUnderTheCursor) {
  FrameBuffer::Options options = layered(100, 1);
  options.near = 8;
  FrameBuffer buffer(options);
  buffer.scrub(10);
  fetch(buffer);
  std::vector<FetchJob> beside;
  for (int i = 0; i < 2; ++i) beside.push_back(*buffer.next_fetch());
  EXPECT_EQ(asked(beside[0]), (Asked{11, 0, 1}));
  EXPECT_EQ(asked(beside[1]), (Asked{12, 0, 1}));
  buffer.scrub(12);
  for (const FetchJob& job : beside)
    EXPECT_FALSE(job.stop.stop_requested()) << "one is what is waited for: " << job.frame;
  std::optional<FetchJob> more;
  std::thread fetcher([&] { more = buffer.next_fetch(); });
  buffer.scrub(30);
  fetcher.join();
  EXPECT_EQ(asked(*more), (Asked{30, 0, 1})) << "two were enough";
  for (const FetchJob& job : beside)
    EXPECT_EQ(job.stop.stop_requested(), job.frame != 12) << "where the cursor was: " << job.frame;
}

TEST(FrameBuffer, AsksForTheNewestCursorFirstAndCancelsAllButTheOneBefore) {
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

TEST(FrameBuffer, ShowsWhereAFastDragPassedButNeverGoesBack) {
  FrameBuffer buffer(layered(100, 1));
  for (int i = 0; i < 2; ++i) fetch(buffer);
  buffer.deliver(*buffer.next_wanted(), picture(0));
  buffer.scrub(10);
  ASSERT_NE(buffer.best(), nullptr) << "the last picture stays";
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

TEST(FrameBuffer, ShowsNothingOfADragAfterItsEndButTheFrameItEndedAt) {
  FrameBuffer buffer(layered(100, 1));
  buffer.scrub(10);
  fetch(buffer);
  const auto ten = buffer.next_wanted();
  buffer.scrub(20);
  buffer.seek(20);
  buffer.deliver(*ten, picture(10));
  EXPECT_EQ(buffer.best(), nullptr);
}

// Backward.

TEST(FrameBuffer, SaysHowFullItIs) {
  FrameBuffer buffer(layered(100, 2));
  EXPECT_EQ(buffer.fill().fetched, 0u);
  EXPECT_EQ(buffer.fill().window, 5u);
  EXPECT_EQ(buffer.fill().ahead, 3u);
  fetch(buffer);  // the base of 0
  EXPECT_EQ(buffer.fill().fetched, 1u);
  fetch(buffer);
  fetch(buffer);  // the base of 1
  EXPECT_EQ(buffer.fill().fetched, 2u);
  buffer.deliver(*buffer.next_wanted(), picture(0));
  EXPECT_EQ(buffer.fill().made, 1u);
  buffer.set_pace({8, 0, true, false});
  EXPECT_EQ(buffer.fill().window, 9u);
}

}  // namespace
}  // namespace pointreel
