// A live stream is watched over a link and from a server that fail in every way. The viewer must
// see what was published, and the newest frames as soon as the link is back.

#include <algorithm>
#include <csignal>
#include <memory>
#include <stdexcept>
#include <thread>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/base/unix_time.h"
#include "tests/fault/fault_reel.h"
#include "tests/fault/live_stage.h"
#include "tests/fault/served_reel.h"
#include "tests/link/link_emulator.h"
#include "tests/load/load_generator.h"

namespace pointreel::live_fault_test {
namespace {

using namespace std::chrono_literals;
using testing::AnyOf;
using testing::HasSubstr;

/// `scheme` and `end` say how the stream is watched.
class LiveFault : public testing::Test {
 protected:
  explicit LiveFault(const char* scheme = "ws", const char* end = "") {
    auto link = LinkEmulator::start({server_.address()});
    if (!link) throw std::runtime_error(link.error().message);
    link_ = std::move(*link);
    LiveReel::get();
    publisher_ =
        std::make_unique<StagePublisher>("ws://" + server_.address() + "/live/ball?publish");
    watcher_ =
        std::make_unique<LiveWatcher>(scheme + ("://" + link_->address()) + "/live/ball" + end);
    if (!watcher_->sees(5)) ADD_FAILURE() << watcher_->trouble().value_or("nothing came");
  }
  ~LiveFault() override {
    const auto shown = watcher_->shown();
    watcher_.reset();
    std::size_t wrong = 0, back = 0;
    for (std::size_t i = 0; i < shown.size(); ++i) {
      wrong += !shown[i].right;
      // The same frame may be shown again with more layers.
      const bool is_first_of_successor = i > 0 && shown[i - 1].capture_us < successor_since_us_ &&
                                         shown[i].capture_us >= successor_since_us_;
      if (i > 0 && !is_first_of_successor) back += shown[i].frame < shown[i - 1].frame;
    }
    EXPECT_EQ(wrong, 0u) << "of " << shown.size() << " pictures";
    EXPECT_EQ(back, 0u) << "pictures are older than those before them";
  }

  /// Expects that the next pictures are current, not from the time at which the link went down.
  void expect_to_be_live() {
    const std::uint64_t newest = publisher_->newest_us();
    const std::size_t before = watcher_->shown().size();
    ASSERT_TRUE(watcher_->sees_what_is_as_new_as(newest));
    const auto shown = watcher_->shown();
    const auto older =
        std::count_if(shown.begin() + static_cast<std::ptrdiff_t>(before), shown.end(),
                      [&](const auto& one) { return one.capture_us < newest; });
    EXPECT_LE(older, behind_);
    EXPECT_TRUE(watcher_->hears_of_trouble(false));
  }

  ServerProcess server_{FaultReel::get().path(), 0, {"--live"}};
  std::unique_ptr<LinkEmulator> link_;
  std::unique_ptr<StagePublisher> publisher_;
  std::unique_ptr<LiveWatcher> watcher_;
  std::ptrdiff_t behind_ = 3;             ///< this many frames are not a delay
  std::uint64_t successor_since_us_ = 0;  ///< all frames captured before are the first publisher's
};

TEST_F(LiveFault, playback_resumes_after_the_server_is_killed_and_restarted) {
  const int port = server_.port();
  server_.kill();
  ASSERT_TRUE(watcher_->hears_of_trouble());
  EXPECT_EQ(watcher_->trouble()->find('\n'), std::string::npos);
  server_ = ServerProcess(FaultReel::get().path(), port, {"--live"});
  expect_to_be_live();
}

TEST_F(LiveFault, playback_resumes_after_the_link_is_cut) {
  link_->set({.cut = true});
  ASSERT_TRUE(watcher_->hears_of_trouble());
  EXPECT_THAT(*watcher_->trouble(), AnyOf(HasSubstr("again"), HasSubstr("waiting")));
  link_->set({});
  expect_to_be_live();
}

TEST_F(LiveFault, playback_resumes_after_its_connection_dies_without_notice) {
  link_->forget_connections();
  ASSERT_TRUE(watcher_->connects_again());
  expect_to_be_live();
}

TEST_F(LiveFault, playback_resumes_after_each_of_several_connection_resets) {
  for (int i = 0; i < 5; ++i) {
    link_->reset_connections();
    expect_to_be_live();
  }
}

TEST_F(LiveFault, playback_shows_a_stream_that_arrives_byte_by_byte) {
  link_->set({.split = 1});
  EXPECT_TRUE(watcher_->sees(10));
}

TEST_F(LiveFault, damaged_data_never_shows_a_wrong_picture) {
  link_->set({.corrupt_every = 20'000});
  EXPECT_TRUE(watcher_->sees(60));
  EXPECT_GT(link_->statistics().flipped_bits, 0u);
}

TEST_F(LiveFault, a_departed_publisher_is_reported_and_its_successor_is_shown) {
  publisher_.reset();
  successor_since_us_ = unix_time_us();
  ASSERT_TRUE(watcher_->hears_of_trouble());
  EXPECT_THAT(*watcher_->trouble(), HasSubstr("publisher has gone"));
  std::this_thread::sleep_for(2ms);  // capture times are rounded down to milliseconds
  publisher_ = std::make_unique<StagePublisher>("ws://" + server_.address() + "/live/ball?publish");
  expect_to_be_live();
}

TEST_F(LiveFault, many_viewers_are_served_over_websocket_and_http) {
  LoadOptions options;
  options.viewers = 20;
  options.warm_up = 0.5;
  for (const auto& url :
       {"ws://" + server_.address() + "/live/ball", "http://" + server_.address() + "/ball"}) {
    options.url = url;
    std::uint64_t frames = 0;
    for (options.seconds = 1.0; frames <= 20 && options.seconds < 60.0; options.seconds *= 2.0) {
      const auto load = run_load(options);
      ASSERT_TRUE(load) << load.error().message;
      EXPECT_EQ(load->broken, 0u);
      frames = load->frames;
    }
    EXPECT_GT(frames, 20u) << url;
  }
}

/// The same with a growing manifest and its segments.
class LiveOverHttpFault : public LiveFault {
 protected:
  LiveOverHttpFault() : LiveFault("http", "/reel.json") { behind_ = 90; }
};

TEST_F(LiveOverHttpFault, playback_resumes_after_the_server_is_killed_and_restarted) {
  const int port = server_.port();
  server_.kill();
  ASSERT_TRUE(watcher_->hears_of_trouble());
  server_ = ServerProcess(FaultReel::get().path(), port, {"--live"});
  expect_to_be_live();
}

TEST_F(LiveOverHttpFault, playback_resumes_after_the_link_is_cut) {
  link_->set({.cut = true});
  ASSERT_TRUE(watcher_->hears_of_trouble());
  link_->set({});
  expect_to_be_live();
}

TEST_F(LiveOverHttpFault, a_link_with_every_fault_never_shows_a_wrong_picture) {
  link_->set({.delay = 20ms, .split = 1000, .corrupt_every = 50'000, .reset_after = 200'000});
  EXPECT_TRUE(watcher_->sees(60));
}

}  // namespace
}  // namespace pointreel::live_fault_test
