#include "client/playback/thumbnails.h"

#include <atomic>
#include <mutex>

#include <gtest/gtest.h>

#include "client/source/open_source.h"
#include "tests/packed_reel.h"
#include "tests/wait.h"

namespace pointreel::thumbnails_test {
namespace {

using Frames = std::vector<std::uint32_t>;

/// Records the requests, and lets them through when the test says so.
class WatchedSource : public Source {
 public:
  explicit WatchedSource(std::unique_ptr<Source> source) : source_(std::move(source)) {}
  const Manifest& manifest() const override { return source_->manifest(); }
  Result<FetchedFrame> fetch(const FetchRequest& request) override {
    const std::uint32_t frame = request.frame;
    {
      const std::lock_guard lock(mutex_);
      asked_.push_back(frame);
    }
    ++at_once_;
    EXPECT_LE(at_once_, 1);
    EXPECT_EQ(request.layers.end, 1u);
    wait_until([&] { return open || request.stop.stop_requested(); });
    --at_once_;
    if (request.stop.stop_requested() || frame == broken) return fail("cannot be had");
    return source_->fetch(request);
  }
  Frames asked() {
    const std::lock_guard lock(mutex_);
    return asked_;
  }

  std::atomic<bool> open{true};
  std::uint32_t broken = ~0u;

 private:
  const std::unique_ptr<Source> source_;
  std::atomic<int> at_once_{0};
  std::mutex mutex_;
  Frames asked_;
};

class ThumbnailsTest : public PackTest {
 protected:
  ThumbnailsTest() {
    write_frames(12);
    EXPECT_TRUE(pack(layered_options()));
    source_.emplace(*open_source(reel_.string()));
  }
  static std::optional<FetchedFrame> nothing(std::uint32_t) { return std::nullopt; }
  std::shared_ptr<const SceneFrame> wait(Thumbnails& thumbnails, std::uint32_t frame) {
    std::shared_ptr<const SceneFrame> made;
    EXPECT_TRUE(wait_until([&] { return (made = thumbnails.get(frame)) != nullptr; }));
    return made;
  }

  std::optional<WatchedSource> source_;
};

TEST_F(ThumbnailsTest, are_coarse_frames_that_appear_when_they_are_ready) {
  Thumbnails thumbnails(*source_, nothing);
  EXPECT_EQ(thumbnails.get(7), nullptr);
  const auto frame = wait(thumbnails, 7);
  EXPECT_EQ(frame->index, 7u);
  EXPECT_EQ(frame->layers, 1u);
  EXPECT_LE(frame->svo.depth, Thumbnails::kLevel);
  EXPECT_FALSE(frame->attributes.colors.empty());
  EXPECT_EQ(thumbnails.get(7), frame);
  EXPECT_EQ(source_->asked(), Frames{7}) << "it is fetched only once";
}

TEST_F(ThumbnailsTest, are_prepared_one_at_a_time_newest_request_first) {
  Thumbnails thumbnails(*source_, nothing);
  source_->open = false;
  thumbnails.get(0);
  ASSERT_TRUE(wait_until([&] { return source_->asked().size() == 1; }));
  for (const std::uint32_t frame : {3u, 1u, 2u, 3u}) thumbnails.get(frame);
  source_->open = true;
  ASSERT_TRUE(wait_until([&] { return source_->asked().size() == 4; }));
  EXPECT_EQ(source_->asked(), (Frames{0, 3, 2, 1}));
}

TEST_F(ThumbnailsTest, forget_requests_that_were_passed_long_ago) {
  Thumbnails thumbnails(*source_, nothing);
  source_->open = false;
  thumbnails.get(0);
  ASSERT_TRUE(wait_until([&] { return source_->asked().size() == 1; }));
  for (std::uint32_t frame = 1; frame < 12; ++frame) thumbnails.get(frame);
  source_->open = true;
  ASSERT_TRUE(wait_until([&] { return source_->asked().size() == 9; }));
  wait(thumbnails, 4);
  EXPECT_EQ(source_->asked(), (Frames{0, 11, 10, 9, 8, 7, 6, 5, 4}));
}

TEST_F(ThumbnailsTest, keep_the_most_recently_used_within_their_budget_of_bytes) {
  std::uint64_t one = 0;
  {
    Thumbnails thumbnails(*source_, nothing);
    wait(thumbnails, 11);
    one = thumbnails.bytes();
  }
  Thumbnails thumbnails(*source_, nothing, 3 * one + one / 2);
  for (const std::uint32_t frame : {0u, 1u, 2u}) wait(thumbnails, frame);
  thumbnails.get(0);
  wait(thumbnails, 3);
  EXPECT_LE(thumbnails.bytes(), 3 * one + one / 2);
  const std::size_t asked = source_->asked().size();
  for (const std::uint32_t frame : {0u, 2u, 3u}) EXPECT_NE(thumbnails.get(frame), nullptr);
  EXPECT_EQ(source_->asked().size(), asked);
  EXPECT_EQ(thumbnails.get(1), nullptr) << "the least recently used thumbnail is dropped";
}

TEST_F(ThumbnailsTest, keep_one_however_large_it_is) {
  Thumbnails thumbnails(*source_, nothing, 1);
  wait(thumbnails, 3);
  wait(thumbnails, 4);
  EXPECT_EQ(thumbnails.get(4)->index, 4u);
}

TEST_F(ThumbnailsTest, reuse_bases_that_are_already_stored) {
  const auto stored = [&](std::uint32_t frame) -> std::optional<FetchedFrame> {
    if (frame != 2) return std::nullopt;
    return *open_source(reel_.string()).value()->fetch({5, {0, 1, true, false}});
  };
  Thumbnails thumbnails(*source_, stored);
  EXPECT_EQ(wait(thumbnails, 2)->index, 2u);
  EXPECT_EQ(source_->asked(), Frames{});
}

TEST_F(ThumbnailsTest, are_not_begun_while_quiet) {
  Thumbnails thumbnails(*source_, nothing);
  thumbnails.set_quiet(true);
  thumbnails.get(1);
  EXPECT_FALSE(wait_until([&] { return !source_->asked().empty(); }, kMoment));
  thumbnails.set_quiet(false);
  wait(thumbnails, 1);
}

TEST_F(ThumbnailsTest, are_not_requested_again_if_they_are_unavailable) {
  source_->broken = 6;
  Thumbnails thumbnails(*source_, nothing);
  thumbnails.get(6);
  ASSERT_TRUE(wait_until([&] { return thumbnails.bytes() > 0; }));
  for (int i = 0; i < 20; ++i) EXPECT_EQ(thumbnails.get(6), nullptr);
  wait(thumbnails, 5);
  EXPECT_EQ(source_->asked(), (Frames{6, 5}));
}

TEST_F(ThumbnailsTest, can_be_destroyed_while_one_is_being_fetched) {
  source_->open = false;
  Thumbnails thumbnails(*source_, nothing);
  thumbnails.get(0);
  thumbnails.get(1);
  ASSERT_TRUE(wait_until([&] { return source_->asked().size() == 1; }));
}

}  // namespace
}  // namespace pointreel::thumbnails_test
