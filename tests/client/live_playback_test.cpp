#include "client/playback/live_playback.h"

#include <atomic>
#include <chrono>
#include <deque>
#include <functional>
#include <set>
#include <thread>
#include <utility>

#include <gtest/gtest.h>

#include "codec/live/live.h"
#include "pointreel/codec.h"
#include "pointreel/draco.h"
#include "tests/live_frames.h"
#include "tests/wait.h"

namespace pointreel::live_playback_test {
namespace {

using std::chrono::milliseconds;

const Cube kCube{{0.0, 0.0, 0.0}, 4.0};

/// A frame with `points` points of a grid in the cube's corner, as an octree with `layers` layers.
LiveFrame live_frame(std::uint32_t number, int points, std::size_t layers = 3) {
  PointCloud cloud;
  for (int i = 0; i < points; ++i)
    cloud.positions.push_back(0.01f * glm::vec3(1 + i % 20, 1 + i / 20 % 20, 1 + i / 400));
  OctreeOptions octree;
  octree.entropy = Entropy::none;
  octree.depth = DepthRule::fixed(11);
  const auto encoded = encode_frame(cloud, kCube, {octree});
  EXPECT_TRUE(encoded);
  LiveFrame frame;
  frame.number = number;
  frame.capture_us = 1'000'000 + number;
  frame.layers_sent = 3;
  for (std::size_t i = 0; i < std::min(layers, encoded->layers.size()); ++i) {
    const Bytes& geometry = encoded->layers[i].geometry;
    frame.frame.layers.push_back({geometry, {static_cast<std::uint32_t>(geometry.size()), 0, 0}});
  }
  return frame;
}

LiveFrame broken_frame(std::uint32_t number) {
  LiveFrame frame = live_frame(number, 10);
  SharedBytes& base = frame.frame.layers[0].bytes;
  Bytes damaged(base.begin(), base.end());
  damaged[9] ^= 0xff;
  base = std::move(damaged);
  return frame;
}

/// A source that gives what the test pushes.
class FakeLiveSource : public LiveSource {
 public:
  std::optional<LiveHello> hello(milliseconds) override {
    const std::lock_guard lock(mutex_);
    return hello_;
  }
  std::optional<LiveFrame> next(milliseconds timeout) override {
    std::unique_lock lock(mutex_);
    idle_ = frames_.empty();
    changed_.wait_for(lock, timeout, [this] { return cancelled_ || !frames_.empty(); });
    idle_ = false;
    if (frames_.empty()) return std::nullopt;
    LiveFrame frame = std::move(frames_.front());
    frames_.pop_front();
    return frame;
  }
  void set_on_sound(OnSound) override {}
  std::optional<std::string> trouble() const override { return std::nullopt; }
  LiveCounts counts() const override { return {}; }
  void cancel() override {
    {
      const std::lock_guard lock(mutex_);
      cancelled_ = true;
    }
    changed_.notify_all();
  }

  void say(const LiveHello& hello) {
    const std::lock_guard lock(mutex_);
    hello_ = hello;
  }
  void push(LiveFrame frame) {
    {
      const std::lock_guard lock(mutex_);
      frames_.push_back(std::move(frame));
    }
    changed_.notify_all();
  }
  /// Whether the playback has dealt with every pushed frame and waits for another.
  bool idle() const {
    const std::lock_guard lock(mutex_);
    return idle_ && frames_.empty();
  }

 private:
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::optional<LiveHello> hello_;
  std::deque<LiveFrame> frames_;
  bool cancelled_ = false, idle_ = false;
};

/// The hello of a stream whose z axis points up.
LiveHello hello_of(std::uint64_t session) {
  LiveHello hello = plain_hello(session);
  hello.up = 'z';
  return hello;
}

struct LiveTest : testing::Test {
  LiveTest() {
    auto fake = std::make_unique<FakeLiveSource>();
    source = fake.get();
    LivePlayback::Options options;
    options.prepare.mode = DrawMode::point;
    playback = std::make_unique<LivePlayback>(std::move(fake), "somewhere", options,
                                              [this](std::uint32_t frame, const Error&) {
                                                const std::lock_guard lock(mutex);
                                                broken.insert(frame);
                                              });
  }

  /// Returns the first update that satisfies `done`.
  Playback::Update update_until(const std::function<bool(const Playback::Update&)>& done) {
    Playback::Update update;
    EXPECT_TRUE(wait_until([&] { return done(update = playback->update({})); }));
    return update;
  }
  Playback::Update wait_for(std::uint32_t number) {
    return update_until(
        [number](const auto& update) { return update.frame && update.frame->index == number; });
  }

  FakeLiveSource* source = nullptr;
  std::mutex mutex;
  std::set<std::uint32_t> broken;
  std::unique_ptr<LivePlayback> playback;  // last, since its threads use the members above
};

TEST_F(LiveTest, shows_nothing_new_while_paused_and_resumes_with_the_newest_frame) {
  playback->pause();
  source->say(plain_hello(1));
  source->push(live_frame(1, 100));
  const auto first = wait_for(1).frame;  // before it, there is no picture to pause on
  for (std::uint32_t number = 2; number < 6; ++number) source->push(live_frame(number, 100));
  EXPECT_TRUE(wait_until([&] { return source->idle(); }));
  EXPECT_EQ(playback->update({}).frame, first);
  playback->play();
  EXPECT_TRUE(playback->playing());
  source->push(live_frame(9, 100));
  wait_for(9);
  EXPECT_EQ(playback->dropped(), 0u);
}

TEST_F(LiveTest, shows_each_frame_with_its_capture_time) {
  source->say(hello_of(1));
  EXPECT_EQ(playback->update({}).frame, nullptr);
  for (std::uint32_t number : {3u, 4u, 9u}) {
    source->push(live_frame(number, 100));
    const Playback::Update update = wait_for(number);
    ASSERT_TRUE(update.frame);
    EXPECT_EQ(update.frame->time_us, 1'000'000u + number);
    EXPECT_EQ(update.frame->svo.leaf_count(), 100u);
    EXPECT_FALSE(update.refined);
    EXPECT_FALSE(update.ended);
  }
  EXPECT_EQ(playback->up(), 'z');
  EXPECT_EQ(playback->dropped(), 0u);
  EXPECT_EQ(playback->errors(), 0u);
}

TEST_F(LiveTest, takes_its_bounds_from_the_first_frame_if_the_publisher_states_none) {
  source->say(hello_of(1));
  EXPECT_TRUE(playback->bounds().empty());
  source->push(live_frame(0, 400));
  wait_for(0);
  const Box bounds = playback->bounds();
  ASSERT_FALSE(bounds.empty());
  EXPECT_NEAR(bounds.max.x, 0.2, 0.01);
  EXPECT_NEAR(bounds.min.x, 0.01, 0.01);
}

TEST_F(LiveTest, reports_a_damaged_frame_and_goes_on) {
  source->say(hello_of(1));
  source->push(live_frame(0, 100));
  const auto first = wait_for(0).frame;
  source->push(broken_frame(1));
  update_until([this](const auto&) { return playback->errors() == 1; });
  EXPECT_EQ(playback->update({}).frame, first) << "the last good picture must stay";
  source->push(live_frame(2, 100));
  wait_for(2);
  EXPECT_EQ(playback->errors(), 1u);
  const std::lock_guard lock(mutex);
  EXPECT_EQ(broken, std::set<std::uint32_t>{1});
}

TEST_F(LiveTest, refines_a_frame_whose_finer_layers_arrive_later) {
  source->say(hello_of(1));
  source->push(live_frame(5, 400, 1));
  const Playback::Update coarse = wait_for(5);
  EXPECT_LT(coarse.frame->svo.depth, 11);
  source->push(live_frame(5, 400, 3));
  const Playback::Update fine = update_until(
      [](const auto& update) { return update.frame && update.frame->svo.depth == 11; });
  EXPECT_TRUE(fine.refined);
  EXPECT_EQ(fine.frame->index, 5u);
  EXPECT_FALSE(playback->update({}).refined) << "it is reported only once";
  EXPECT_EQ(playback->dropped(), 0u);
}

TEST_F(LiveTest, shows_a_restarted_publisher_although_its_numbers_start_over) {
  source->say(hello_of(1));
  source->push(live_frame(100, 100));
  wait_for(100);
  source->say(hello_of(2));
  source->push(live_frame(0, 50));
  EXPECT_EQ(wait_for(0).frame->svo.leaf_count(), 50u);
}

TEST_F(LiveTest, never_goes_back_and_counts_the_frames_that_it_dropped) {
  source->say(hello_of(1));
  constexpr std::uint32_t kFrames = 60;
  std::atomic<bool> all_pushed{false};
  std::thread pusher([&] {
    for (std::uint32_t i = 1; i <= kFrames; ++i)
      source->push(live_frame(i, i % 7 == 0 ? 4000 : 40));  // some take longer than later frames
    all_pushed = true;
  });
  std::uint32_t last = 0, shown = 0;
  update_until([&](const auto& update) {
    if (!update.frame || update.frame->index == last) return false;
    EXPECT_GT(update.frame->index, last);
    last = update.frame->index;
    ++shown;
    return last == kFrames;
  });
  pusher.join();
  // A skipped frame may still be in the hands of a thread.
  update_until([&](const auto&) { return playback->dropped() + shown == kFrames; });
  EXPECT_EQ(playback->errors(), 0u);
}

TEST_F(LiveTest, ends_while_frames_are_being_prepared) {
  source->say(hello_of(1));
  for (std::uint32_t i = 1; i <= 5; ++i) source->push(live_frame(i, 4000));
  playback.reset();
}

}  // namespace
}  // namespace pointreel::live_playback_test
