#include "client/playback/reel_playback.h"

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <set>
#include <thread>
#include <utility>

#include "client/source/open_source.h"
#include "tests/packed_reel.h"
#include "tests/wait.h"

namespace pointreel::reel_playback_test {
namespace {

using std::chrono::milliseconds;

/// A package on disk behind a link that the test opens and closes.
class GatedSource : public Source {
 public:
  explicit GatedSource(std::unique_ptr<Source> source) : source_(std::move(source)) {}
  const Manifest& manifest() const override { return source_->manifest(); }
  Result<FetchedFrame> fetch(const FetchRequest& request) override {
    {
      std::unique_lock lock(mutex_);
      while (!open_ && !cancelled_ && !request.stop.stop_requested())
        changed_.wait_for(lock, milliseconds(1));
      if (cancelled_ || request.stop.stop_requested()) {
        ++stopped_;
        return fail("stopped");
      }
      layers_.insert(request.layers.end);
    }
    auto fetched = source_->fetch(request);
    const std::lock_guard lock(mutex_);
    if (fetched) use_.bytes += fetched->size();
    use_.receiving = std::chrono::microseconds(use_.bytes / 100);  // 800 Mbit/s
    return fetched;
  }
  void cancel() override {
    const std::lock_guard lock(mutex_);
    cancelled_ = true;
  }
  LinkUse link_use() const override {
    const std::lock_guard lock(mutex_);
    return use_;
  }
  void open(bool open) {
    const std::lock_guard lock(mutex_);
    open_ = open;
    changed_.notify_all();
  }
  std::multiset<std::uint32_t> layers() {
    const std::lock_guard lock(mutex_);
    return layers_;
  }

 private:
  const std::unique_ptr<Source> source_;
  mutable std::mutex mutex_;
  LinkUse use_;
  std::condition_variable changed_;
  bool open_ = true, cancelled_ = false;
  int stopped_ = 0;
  std::multiset<std::uint32_t> layers_;  ///< the last layer of each fetch
};

/// Thirty frames of a ball at ten frames per second, in three layers, viewed from near.
class ReelPlaybackTest : public PackTest {
 protected:
  static constexpr std::uint32_t kFrames = 30;

  ReelPlaybackTest() {
    write_frames(kFrames);
    PackOptions packing = options();
    OctreeOptions octree;
    octree.depth = DepthRule::fixed(10);
    packing.encode.codec = octree;
    packing.fps = 10.0;
    packing.segment_frames = 10;
    EXPECT_TRUE(pack(packing));
  }

  /// Begins, and waits for the first frame.
  void start(bool loop = true, double speed = 1.0, std::uint64_t start_us = 0) {
    begin(loop, speed, start_us);
    until([&](const auto& update) { return update.frame && playback_->playing(); });
  }

  void begin(bool loop = true, double speed = 1.0, std::uint64_t start_us = 0) {
    auto source = open_source(reel_.string());
    ASSERT_TRUE(source) << source.error().message;
    auto gated = std::make_unique<GatedSource>(std::move(*source));
    source_ = gated.get();
    source_->open(!held_back_);
    ReelPlayback::Options options;
    options.remote = remote_;
    options.cache_bytes = cache_bytes_;
    options.loop = loop;
    options.speed = speed;
    options.start_us = start_us;
    Camera camera;
    camera.frame_bounds(gated->manifest().bounds, 1.0);
    camera.zoom(0.05);
    playback_ = std::make_unique<ReelPlayback>(std::move(gated), options, camera, glm::ivec2(2000),
                                               [](std::uint32_t, const Error&) {});
  }

  ReelPlayback::Update update() { return playback_->update(now_); }
  /// Waits until `done` holds, while time stands still.
  void until(const std::function<bool(const ReelPlayback::Update&)>& done) {
    if (HasFatalFailure()) return;  // this test has waited long enough
    ASSERT_TRUE(wait_until([&] {
      now_ += std::chrono::microseconds(1);
      return done(last_ = update());
    }));
  }
  void until_shown(std::uint32_t frame) {
    until([&](const auto& update) { return update.frame && update.frame->index == frame; });
  }
  void until_whole(std::uint32_t frame) {
    until([&](const auto& update) {
      return update.frame && update.frame->index == frame && update.frame->level == kWholeFrame;
    });
  }
  /// The last frame that is there without a gap from the first on, with however many layers.
  std::uint32_t last_before_gap() const {
    const std::vector<BufferedRange> ranges = playback_->buffered();
    std::uint32_t last = ranges.front().last;
    for (const BufferedRange& range : ranges)
      if (range.first == last + 1) last = range.last;
    return last;
  }
  void pass(milliseconds time) { now_ += time; }

  Clock::TimePoint now_{std::chrono::hours(1)};
  bool remote_ = true;
  std::uint64_t cache_bytes_ = 0;
  bool held_back_ = false;  ///< nothing arrives until the source is opened
  GatedSource* source_ = nullptr;
  std::unique_ptr<ReelPlayback> playback_;
  ReelPlayback::Update last_;
};

TEST_F(ReelPlaybackTest, shows_every_frame_forward_and_across_the_end_of_the_loop) {
  start();
  until_shown(0);
  for (std::uint32_t frame = 1; frame < 2 * kFrames; ++frame) {
    pass(milliseconds(100));
    until_shown(frame % kFrames);
  }
  EXPECT_EQ(playback_->dropped(), 0u);
  EXPECT_EQ(playback_->errors(), 0u);
}

TEST_F(ReelPlaybackTest, decodes_a_loop_once_that_fits_the_cache) {
  remote_ = false;  // then what has been decoded is fetched again before it is decoded again
  for (const bool cached : {false, true}) {
    cache_bytes_ = cached ? std::uint64_t{1} << 30 : 0;
    start();
    until_whole(0);  // its base comes first, and is made again
    for (std::uint32_t frame = 1; frame < 2 * kFrames; ++frame) {
      pass(milliseconds(100));
      until_shown(frame % kFrames);
    }
    playback_->pause(now_);
    playback_->scrub_to(300'000, now_);
    until_shown(3);
    playback_->scrub_end(now_);
    until_whole(3);
    if (cached) {
      EXPECT_EQ(source_->layers().size(), kFrames);
      EXPECT_EQ(playback_->statistics().reused, kFrames + 1);
    } else {
      EXPECT_GT(source_->layers().size(), 2 * kFrames);
      EXPECT_EQ(playback_->statistics().reused, 0u);
    }
  }
}

TEST_F(ReelPlaybackTest, shows_every_frame_backward_and_across_the_start_of_the_loop) {
  start(true, -1.0, 550'000);
  until_shown(5);
  for (std::uint32_t i = 1; i < 2 * kFrames; ++i) {
    pass(milliseconds(100));
    until_shown((5 + 2 * kFrames - i) % kFrames);
  }
  EXPECT_EQ(playback_->dropped(), 0u);
}

TEST_F(ReelPlaybackTest, ends_without_a_loop_in_both_directions) {
  for (const double speed : {4.0, -4.0}) {
    start(false, speed, speed > 0.0 ? 2'700'000 : 250'000);
    until_shown(speed > 0.0 ? 27 : 2);
    pass(milliseconds(500));
    until([](const auto& update) { return update.ended; });
  }
}

TEST_F(ReelPlaybackTest, reverses_where_it_is) {
  start();
  until_shown(0);
  pass(milliseconds(1050));
  until_shown(10);
  playback_->set_speed(-1.0, now_);
  pass(milliseconds(100));
  until_shown(9);
}

TEST_F(ReelPlaybackTest, can_be_paused_stepped_and_dragged_before_its_first_frame_arrives) {
  held_back_ = true;
  begin();
  EXPECT_TRUE(playback_->playing()) << "it plays as soon as it can";
  playback_->pause(now_);
  EXPECT_FALSE(playback_->playing());
  playback_->play(now_);
  EXPECT_TRUE(playback_->playing());
  playback_->scrub_to(700'000, now_);
  playback_->scrub_end(now_);
  EXPECT_TRUE(playback_->playing()) << "it played before the drag";
  playback_->step(1, now_);
  EXPECT_FALSE(playback_->playing());
  source_->open(true);
  until_shown(8);
  pass(milliseconds(500));
  until_shown(8);
  EXPECT_FALSE(playback_->playing());
}

TEST_F(ReelPlaybackTest, seeks_and_steps_to_exact_frames_while_paused) {
  start();
  until_shown(0);
  playback_->pause(now_);
  for (const std::uint32_t frame : {17u, 3u, 29u, 0u}) {
    playback_->seek(frame * 100'000 + 50'000, now_);
    until_whole(frame);
  }
  playback_->step(-1, now_);
  until_whole(29);
  playback_->step(1, now_);
  playback_->step(1, now_);
  until_whole(1);
  pass(std::chrono::seconds(10));
  until_whole(1);
}

TEST_F(ReelPlaybackTest, stalls_while_the_link_is_down_and_drops_no_frame) {
  start();
  until_shown(0);
  source_->open(false);
  // The frames that were fetched ahead without a gap are played.
  until([&](const auto& update) {
    // Time passes only where the picture of its frame is there, or a busy machine would drop it.
    const std::uint32_t due = playback_->timeline().frame_at(playback_->position_us(now_));
    if (update.frame->index == due) pass(milliseconds(20));
    return playback_->statistics().buffered_seconds == 0.0 &&
           update.frame->index == last_before_gap();
  });
  const std::uint32_t frame = last_.frame->index;
  const auto stalls = playback_->statistics().stalls;
  pass(milliseconds(700));
  EXPECT_EQ(update().frame->index, frame);
  source_->open(true);
  until([&](const auto&) { return playback_->statistics().stalls > stalls; });
  EXPECT_GT(playback_->statistics().longest_stall_seconds, 0.6);
  const auto before = playback_->dropped();
  until_shown((frame + 1) % kFrames);
  for (std::uint32_t i = 2; i < 20; ++i) {
    pass(milliseconds(100));
    until_shown((frame + i) % kFrames);
  }
  EXPECT_EQ(playback_->dropped(), before);
}

TEST_F(ReelPlaybackTest, shows_the_base_under_a_drag_and_refines_it_on_release) {
  start();
  until_shown(0);
  playback_->scrub_begin(now_);
  EXPECT_TRUE(playback_->scrubbing());
  for (const std::uint32_t frame : {20u, 11u, 28u, 5u}) {
    playback_->scrub_to(frame * 100'000 + 50'000, now_);
    until_shown(frame);
    pass(milliseconds(500));
    until_shown(frame);
  }
  EXPECT_TRUE(playback_->playing()) << "playback goes on afterwards";
  playback_->scrub_end(now_);
  until_shown(5);
  pass(milliseconds(100));
  until_shown(6);
  playback_->pause(now_);
  until_whole(6);
}

TEST_F(ReelPlaybackTest, requests_only_bases_during_a_drag) {
  start();
  until_shown(0);
  playback_->pause(now_);
  until_whole(0);
  // Everything that it wants has arrived, so nothing more is requested.
  until(
      [&](const auto&) { return playback_->buffered() == std::vector<BufferedRange>{{0, 20, 3}}; });
  playback_->scrub_begin(now_);
  const auto before = source_->layers();
  playback_->scrub_to(2'550'000, now_);
  until_shown(25);
  EXPECT_EQ(last_.frame->layers, 1u);
  // The frame itself and half a second on each side: 21 to 29.
  until([&](const auto&) { return source_->layers().count(1) == before.count(1) + 9; });
  EXPECT_EQ(source_->layers().count(3), before.count(3));
  playback_->scrub_end(now_);
  until_whole(25);
  EXPECT_FALSE(playback_->playing());
}

TEST_F(ReelPlaybackTest, reports_the_chosen_layers_and_the_reasons) {
  start();
  until_shown(0);
  playback_->pause(now_);
  until_whole(0);
  pass(milliseconds(100));
  until([&](const auto&) { return !playback_->chosen().empty(); });
  const auto chosen = playback_->chosen();
  EXPECT_EQ(chosen.back().decision.layers.end, 3u);
  EXPECT_EQ(chosen.back().decision.limit, Limit::none);
  Camera far;
  far.frame_bounds(playback_->manifest().bounds, 1.0);
  far.zoom(40.0);
  playback_->look(far, glm::ivec2(200));
  EXPECT_EQ(playback_->decision(), (LayerDecision{{0, 1, true, true}, Limit::view}));
}

TEST_F(ReelPlaybackTest, fetches_a_frame_only_once_however_often_it_is_shown) {
  start();
  until_shown(0);
  playback_->pause(now_);
  for (std::uint32_t frame = 0; frame < kFrames; ++frame) {
    playback_->seek(frame * 100'000, now_);
    until_whole(frame);
  }
  playback_->seek(0, now_);
  playback_->play(now_);
  const auto bytes = playback_->statistics().fetched_bytes;
  for (std::uint32_t frame = 0; frame < 3 * kFrames; ++frame) {
    pass(milliseconds(100));
    until_shown(frame % kFrames);
  }
  EXPECT_EQ(playback_->statistics().fetched_bytes, bytes);
}

TEST_F(ReelPlaybackTest, repeats_a_loop_range_in_either_direction_without_dropping_a_frame) {
  start(false);
  until_shown(0);
  playback_->set_loop_range(LoopRange{400'000, 900'000}, now_);
  EXPECT_EQ(playback_->loop_range(), (LoopRange{400'000, 900'000}));
  for (std::uint32_t i = 1; i < 24; ++i) {
    pass(milliseconds(100));
    until_shown(i < 9 ? i : 4 + (i - 9) % 5);
  }
  EXPECT_EQ(last_.frame->index, 8u);
  playback_->set_speed(-1.0, now_);
  for (std::uint32_t i = 1; i < 18; ++i) {
    pass(milliseconds(100));
    until_shown(8 - i % 5);
  }
  EXPECT_EQ(playback_->dropped(), 0u);
  EXPECT_EQ(playback_->errors(), 0u);
}

TEST_F(ReelPlaybackTest, has_the_start_of_a_loop_range_ready_before_its_end) {
  start(false, 1.0, 1'350'000);
  until_shown(13);
  playback_->set_loop_range(LoopRange{200'000, 1'500'000}, now_);
  const auto ready = [&](std::uint32_t frame) {
    const auto ranges = playback_->buffered();
    return std::any_of(ranges.begin(), ranges.end(), [&](const BufferedRange& range) {
      return range.first <= frame && frame <= range.last;
    });
  };
  // They are fetched in parallel, so the arrival of the last implies nothing about the others.
  const std::vector<std::uint32_t> next{14, 2, 3, 4, 5};
  until([&](const auto&) { return std::all_of(next.begin(), next.end(), ready); });
  source_->open(false);
  for (const std::uint32_t frame : next) {
    pass(milliseconds(100));
    until_shown(frame);
  }
  EXPECT_EQ(playback_->dropped(), 0u);
}

TEST_F(ReelPlaybackTest, plays_on_from_beyond_a_loop_range) {
  start();
  playback_->set_loop_range(LoopRange{200'000, 600'000}, now_);
  playback_->seek(2'750'000, now_);
  until_shown(27);
  for (const std::uint32_t frame : {28u, 29u, 0u, 1u, 2u, 3u, 4u, 5u, 2u, 3u}) {
    pass(milliseconds(100));
    until_shown(frame);
  }
  playback_->set_loop_range(std::nullopt, now_);
  pass(milliseconds(400));
  until_shown(7);
}

TEST_F(ReelPlaybackTest, reports_the_buffered_frames) {
  start();
  until_shown(0);
  playback_->pause(now_);
  // Two seconds ahead at ten frames per second.
  until(
      [&](const auto&) { return playback_->buffered() == std::vector<BufferedRange>{{0, 20, 3}}; });
  source_->open(false);
  playback_->seek(2'900'000, now_);
  EXPECT_EQ(playback_->buffered(), (std::vector<BufferedRange>{{0, 20, 3}}));
}

TEST_F(ReelPlaybackTest, prepares_frames_again_for_another_delta) {
  start();
  playback_->pause(now_);
  playback_->set_prepare_options({.mode = DrawMode::voxel, .delta = 0.05});
  until([&](const auto& update) { return update.frame && update.frame->svo.depth > 0; });
  until_whole(0);
  const int fine = last_.frame->svo.depth;
  playback_->set_prepare_options({.mode = DrawMode::voxel, .delta = 0.9});
  until([&](const auto& update) { return update.frame && update.frame->svo.depth < fine; });
  playback_->set_prepare_options({.mode = DrawMode::voxel, .delta = 0.05});
  until([&](const auto& update) { return update.frame && update.frame->svo.depth == fine; });
}

TEST_F(ReelPlaybackTest, gives_thumbnails_of_any_frame) {
  start();
  playback_->pause(now_);
  until([&](const auto&) { return playback_->statistics().buffered_seconds > 1.9; });
  EXPECT_EQ(playback_->thumbnail(25), nullptr);
  until([&](const auto&) {
    const auto frame = playback_->thumbnail(25);
    return frame && frame->index == 25 && frame->layers == 1;
  });
  source_->open(false);  // frames that have arrived need no link
  until([&](const auto&) { return playback_->thumbnail(3) != nullptr; });
  EXPECT_EQ(playback_->thumbnail(kFrames), nullptr);
  EXPECT_GT(playback_->statistics().frame_bytes, 0u);
  EXPECT_GT(playback_->statistics().stored_bytes, 0u);
}

TEST_F(ReelPlaybackTest, fetches_normals_only_while_they_are_shown) {
  start();
  playback_->pause(now_);
  playback_->set_prepare_options({.mode = DrawMode::voxel});
  const auto has_normals = [&](bool has) {
    return [has](const ReelPlayback::Update& update) {
      return update.frame && update.frame->svo.depth > 0 &&
             update.frame->attributes.normals.empty() != has;
    };
  };
  until(has_normals(false));
  playback_->set_prepare_options({.mode = DrawMode::voxel, .show_normals = true});
  until(has_normals(true));
  EXPECT_FALSE(last_.frame->normals_estimated);
  EXPECT_TRUE(playback_->choice(kWholeFrame).normals);
  playback_->set_prepare_options({.mode = DrawMode::voxel});
  until(has_normals(false));
}

TEST_F(ReelPlaybackTest, fetches_fewer_or_more_layers_for_another_pixel_size) {
  start();
  playback_->pause(now_);
  until_whole(0);
  Camera camera;
  camera.frame_bounds(playback_->manifest().bounds, 1.0);
  playback_->set_prepare_options({.pixel_size = 100.0f});
  playback_->look(camera, glm::ivec2(2000));
  playback_->seek(2'900'000, now_);  // not fetched yet
  until_shown(29);
  EXPECT_LT(last_.frame->level, 10);
  playback_->set_prepare_options({.pixel_size = 0.1f});
  playback_->look(camera, glm::ivec2(2000));
  until_whole(29);
}

}  // namespace
}  // namespace pointreel::reel_playback_test
