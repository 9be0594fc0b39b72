// A package is played over a link and from a server that fail in every way. The last picture stays,
// one line says what is wrong, playback continues where it was, and no picture is ever wrong.

#include <memory>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/fault/fault_reel.h"
#include "tests/fault/served_reel.h"
#include "tests/fault/watcher.h"
#include "tests/link/link_emulator.h"

namespace pointreel::package_fault_test {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;

class PackageFault : public testing::Test {
 protected:
  PackageFault() {
    auto link = LinkEmulator::start({server_.address()});
    if (!link) throw std::runtime_error(link.error().message);
    link_ = std::move(*link);
    // A link that is hardly faster than the reel leaves a player little buffer.
    link_->set(normal());
  }
  ~PackageFault() override {
    if (!watcher_) return;
    const auto shown = watcher_->shown();
    watcher_.reset();
    std::size_t wrong = 0;
    for (const Watcher::Shown& each : shown) wrong += !each.right;
    EXPECT_EQ(wrong, 0u) << "of " << shown.size() << " pictures";
  }

  LinkConditions normal() const {
    LinkConditions conditions;
    conditions.bits_per_second =
        static_cast<std::uint64_t>(1.5 * FaultReel::get().bits_per_second());
    conditions.delay = 2ms;
    return conditions;
  }

  void play() {
    watcher_ =
        std::make_unique<Watcher>("http://" + link_->address() + "/ball", FaultReel::get().truth());
    ASSERT_TRUE(watcher_->sees(5)) << watcher_->trouble().value_or("");
  }

  /// Expects that the pictures from number `from` on come in order, beginning near the picture
  /// before.
  void expect_in_order(std::size_t from) {
    const auto shown = watcher_->shown();
    const auto frames = static_cast<std::uint32_t>(FaultReel::get().truth().size());
    for (std::size_t i = std::max<std::size_t>(from, 1); i < shown.size(); ++i) {
      const std::uint32_t step = (shown[i].frame + frames - shown[i - 1].frame) % frames;
      EXPECT_LT(step, frames / 2) << "back from " << shown[i - 1].frame << " to " << shown[i].frame;
    }
  }

  ServerProcess server_{FaultReel::get().path()};
  std::unique_ptr<LinkEmulator> link_;
  std::unique_ptr<Watcher> watcher_;
};

TEST_F(PackageFault, playback_resumes_after_the_server_is_killed_and_restarted) {
  play();
  const int port = server_.port();
  server_.kill();
  ASSERT_TRUE(watcher_->hears_of_trouble());
  EXPECT_THAT(*watcher_->trouble(), HasSubstr("; trying again"));
  EXPECT_EQ(watcher_->trouble()->find('\n'), std::string::npos);
  const std::size_t before = watcher_->shown().size();
  server_ = ServerProcess(FaultReel::get().path(), port);
  EXPECT_TRUE(watcher_->sees(10));
  EXPECT_TRUE(watcher_->hears_of_no_trouble());
  EXPECT_EQ(watcher_->blank(), 0u);
  EXPECT_EQ(watcher_->errors(), 0u);
  expect_in_order(before);
}

TEST_F(PackageFault, playback_resumes_after_the_link_is_cut) {
  play();
  LinkConditions cut = normal();
  cut.cut = true;
  link_->set(cut);
  ASSERT_TRUE(watcher_->hears_of_trouble());
  link_->set(normal());
  EXPECT_TRUE(watcher_->sees(10));
  EXPECT_TRUE(watcher_->hears_of_no_trouble());
  EXPECT_EQ(watcher_->blank(), 0u);
  EXPECT_EQ(watcher_->errors(), 0u);
  expect_in_order(0);
}

TEST_F(PackageFault, playback_resumes_after_its_connections_die_without_notice) {
  play();
  link_->forget_connections();
  ASSERT_TRUE(watcher_->heard_of_trouble());
  EXPECT_TRUE(watcher_->sees(10));
  EXPECT_TRUE(watcher_->hears_of_no_trouble());
  EXPECT_EQ(watcher_->errors(), 0u);
  expect_in_order(0);
}

TEST_F(PackageFault, playback_resumes_after_each_of_several_connection_resets) {
  play();
  for (int i = 0; i < 10; ++i) {
    link_->reset_connections();
    EXPECT_TRUE(watcher_->sees(2));
  }
  EXPECT_EQ(watcher_->blank(), 0u);
  EXPECT_EQ(watcher_->errors(), 0u);
  expect_in_order(0);
}

TEST_F(PackageFault, playback_shows_a_package_that_arrives_byte_by_byte) {
  LinkConditions split = normal();
  split.split = 1;
  link_->set(split);
  play();
  EXPECT_TRUE(watcher_->sees(10));
  EXPECT_EQ(watcher_->errors(), 0u);
}

TEST_F(PackageFault, playback_goes_on_over_a_slow_link_with_high_latency) {
  LinkConditions slow;
  slow.bits_per_second = static_cast<std::uint64_t>(0.5 * FaultReel::get().bits_per_second());
  slow.delay = 100ms;
  link_->set(slow);
  play();
  EXPECT_TRUE(watcher_->sees(10));
  EXPECT_EQ(watcher_->errors(), 0u);
  EXPECT_EQ(watcher_->blank(), 0u);
  expect_in_order(0);
}

TEST_F(PackageFault, damaged_data_never_shows_a_wrong_picture) {
  play();
  LinkConditions damaged = normal();
  damaged.corrupt_every = 30'000;
  link_->set(damaged);
  EXPECT_TRUE(watcher_->sees(60));
  EXPECT_GT(link_->statistics().flipped_bits, 0u);
  EXPECT_EQ(watcher_->blank(), 0u);
  expect_in_order(0);
}

TEST_F(PackageFault, playback_goes_on_over_connections_that_end_early) {
  play();
  for (const bool reset : {false, true}) {
    LinkConditions ending = normal();
    (reset ? ending.reset_after : ending.truncate_after) = 20'000;
    link_->set(ending);
    EXPECT_TRUE(watcher_->sees(20));
  }
  EXPECT_EQ(watcher_->blank(), 0u);
  EXPECT_EQ(watcher_->errors(), 0u);
  expect_in_order(0);
}

}  // namespace
}  // namespace pointreel::package_fault_test
