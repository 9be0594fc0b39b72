#include "client/playback/pipeline.h"

#include <algorithm>
#include <mutex>
#include <new>
#include <random>
#include <set>

#include <gtest/gtest.h>

#include "common/threads/tbb_executor.h"
#include "tests/wait.h"

namespace pointreel::pipeline_test {
namespace {

using std::chrono::milliseconds;

constexpr milliseconds kLong{60'000};

/// A source that needs no link. The test sets how long it takes and which fetches fail.
class FakeSource : public Source {
 public:
  explicit FakeSource(std::uint32_t frames) {
    Segment segment;
    for (std::uint32_t i = 0; i < frames; ++i) segment.times_us.push_back(i * 1000);
    manifest_.segments.push_back(std::move(segment));
  }
  const Manifest& manifest() const override { return manifest_; }
  Result<FetchedFrame> fetch(const FetchRequest& request) override {
    const std::uint32_t frame = request.frame;
    const int now = ++fetching;
    most_fetching = std::max(most_fetching.load(), now);
    work_for(delay.load());
    --fetching;
    ++fetches;
    if (cancelled) return fail("cancelled");
    if (broken.contains(frame)) return fail("broken");
    FetchedFrame fetched;
    if (!layered) {
      fetched.file = Bytes{static_cast<std::uint8_t>(frame)};
      return fetched;
    }
    const std::lock_guard lock(mutex_);
    for (std::uint32_t layer = request.layers.first; layer < request.layers.end; ++layer) {
      layers_.insert(layer);
      if (request.fresh) ++fresh;
      const bool damaged = layer == damaged_layer && (damaged_always || !request.fresh);
      fetched.layers.push_back(
          {Bytes{static_cast<std::uint8_t>(damaged ? 255 : frame)}, {1, 0, 0}});
    }
    return fetched;
  }
  void cancel() override { cancelled = true; }
  std::multiset<std::uint32_t> fetched_layers() const {
    const std::lock_guard lock(mutex_);
    return layers_;
  }

  std::set<std::uint32_t> broken;
  bool layered = false;               ///< else files
  std::uint32_t damaged_layer = ~0u;  ///< arrives damaged once, or always
  bool damaged_always = false;
  std::atomic<int> fresh{0};
  std::atomic<std::chrono::microseconds> delay{std::chrono::microseconds(0)};
  std::atomic<int> fetching{0}, most_fetching{0}, fetches{0};
  std::atomic<bool> cancelled{false};

 private:
  Manifest manifest_;
  mutable std::mutex mutex_;
  std::multiset<std::uint32_t> layers_;
};

struct Errors {
  std::mutex mutex;
  std::multiset<std::uint32_t> frames;
  std::multiset<std::uint32_t> seen() {
    const std::lock_guard lock(mutex);
    return frames;
  }
  Pipeline::OnError sink() {
    return [this](std::uint32_t frame, const Error&) {
      const std::lock_guard lock(mutex);
      frames.insert(frame);
    };
  }
};

Result<SceneFrame> prepare(const FrameRequest& request, const FetchedFrame& fetched) {
  EXPECT_EQ(fetched.file.view()[0], static_cast<std::uint8_t>(request.frame));
  SceneFrame scene;
  scene.index = request.frame;
  return scene;
}

FrameBuffer::Options once(std::uint32_t frames, std::uint32_t ahead) {
  FrameBuffer::Options options;
  options.frame_count = frames;
  options.ahead = ahead;
  options.loop = false;
  return options;
}

TEST(Pipeline, every_frame_is_prepared_once_and_shown_in_order_at_uneven_speeds) {
  FakeSource source(60);
  source.delay = std::chrono::microseconds(300);
  FrameBuffer buffer(once(60, 6));
  Errors errors;
  std::atomic<int> prepared{0};
  Pipeline pipeline(source, buffer,
                    [&](const FrameRequest& request, const FetchedFrame& fetched) {
                      // Some frames take longer to decode than the frames after them.
                      if (request.frame % 7 == 0) work_for(milliseconds(3));
                      ++prepared;
                      return prepare(request, fetched);
                    },
                    errors.sink(), {2, 3});
  for (std::uint32_t frame = 0; frame < 60; ++frame) {
    buffer.advance(frame);
    ASSERT_EQ(buffer.wait(kLong), FrameBuffer::State::ready);
    ASSERT_EQ(buffer.best()->index, frame);
  }
  EXPECT_EQ(prepared, 60);
  EXPECT_EQ(source.fetches, 60);
  EXPECT_LE(source.most_fetching, 2);
  EXPECT_TRUE(errors.seen().empty());
}

TEST(Pipeline, parallel_parts_of_frames_use_no_more_threads_than_frames_may) {
  FakeSource source(20);
  FrameBuffer buffer(once(20, 6));
  Errors errors;
  std::atomic<int> parts{0}, working{0}, most_working{0};
  Pipeline pipeline(source, buffer,
                    [&](const FrameRequest& request, const FetchedFrame& fetched) {
                      tbb_executor()(6, [&](int) {
                        const int now = ++working;
                        for (int most = most_working;
                             now > most && !most_working.compare_exchange_weak(most, now);) {
                        }
                        work_for(std::chrono::microseconds(300));
                        --working;
                        ++parts;
                      });
                      return prepare(request, fetched);
                    },
                    errors.sink(), {2, 2});
  for (std::uint32_t frame = 0; frame < 20; ++frame) {
    buffer.advance(frame);
    ASSERT_EQ(buffer.wait(kLong), FrameBuffer::State::ready);
  }
  EXPECT_EQ(parts, 120);
  EXPECT_LE(most_working, 2);
}

TEST(Pipeline, damaged_frames_are_reported_and_playback_goes_on) {
  FakeSource source(20);
  source.broken = {0, 7};
  FrameBuffer buffer(once(20, 4));
  Errors errors;
  Pipeline pipeline(
      source, buffer,
      [&](const FrameRequest& request, const FetchedFrame& fetched) -> Result<SceneFrame> {
        if (request.frame == 12) return fail("no frame");
        return prepare(request, fetched);
      },
      errors.sink(), {2, 2});
  for (std::uint32_t frame = 0; frame < 20; ++frame) {
    buffer.advance(frame);
    const bool broken = frame == 0 || frame == 7 || frame == 12;
    ASSERT_EQ(buffer.wait(kLong), broken ? FrameBuffer::State::failed : FrameBuffer::State::ready);
    if (frame > 0) {
      ASSERT_EQ(buffer.best()->index, broken ? frame - 1 : frame);
    }
  }
  // A frame that does not decode is reported just after the buffer learns that it failed.
  const std::multiset<std::uint32_t> damaged{0, 7, 12};
  EXPECT_TRUE(wait_until([&] { return errors.seen() == damaged; }));
  EXPECT_EQ(pipeline.errors(), 3u);
}

TEST(Pipeline, a_frame_that_has_no_memory_fails_alone) {
  FakeSource source(3);
  FrameBuffer buffer(once(3, 2));
  Errors errors;
  Pipeline pipeline(
      source, buffer,
      [&](const FrameRequest& request, const FetchedFrame& fetched) -> Result<SceneFrame> {
        if (request.frame == 1) throw std::bad_alloc();
        return prepare(request, fetched);
      },
      errors.sink(), {1, 1});
  for (std::uint32_t frame = 0; frame < 3; ++frame) {
    buffer.advance(frame);
    ASSERT_EQ(buffer.wait(kLong),
              frame == 1 ? FrameBuffer::State::failed : FrameBuffer::State::ready);
  }
  EXPECT_TRUE(wait_until([&] { return errors.seen() == std::multiset<std::uint32_t>{1}; }));
}

TEST(Pipeline, fetching_stops_when_the_buffer_is_full) {
  FakeSource source(1000);
  FrameBuffer buffer(once(1000, 5));
  Errors errors;
  Pipeline pipeline(source, buffer, prepare, errors.sink(), {4, 4});
  ASSERT_TRUE(wait_until([&] { return buffer.held() == 6; }));
  EXPECT_FALSE(wait_until([&] { return source.fetches > 6; }, kMoment));
}

TEST(Pipeline, only_frames_of_the_new_place_are_shown_after_a_seek) {
  FakeSource source(200);
  source.delay = std::chrono::microseconds(500);
  FrameBuffer buffer(once(200, 4));
  Errors errors;
  Pipeline pipeline(source, buffer, prepare, errors.sink(), {3, 2});
  std::mt19937 random(5);
  for (int i = 0; i < 100; ++i) {
    const auto target = static_cast<std::uint32_t>(random() % 200);
    buffer.seek(target);
    if (const auto shown = buffer.best()) {
      ASSERT_EQ(shown->index, target);
    }
    if (i % 4 == 0) {
      ASSERT_EQ(buffer.wait(kLong), FrameBuffer::State::ready);
      ASSERT_EQ(buffer.best()->index, target);
    }
  }
  EXPECT_TRUE(errors.seen().empty());
}

TEST(Pipeline, a_seek_does_not_wait_for_the_frame_that_was_being_prepared) {
  FakeSource source(200);
  FrameBuffer buffer(once(200, 4));
  Errors errors;
  std::atomic<int> begun{0};
  Pipeline pipeline(
      source, buffer,
      [&](const FrameRequest& request, const FetchedFrame& fetched) -> Result<SceneFrame> {
        ++begun;
        if (request.frame == 150) return prepare(request, fetched);
        EXPECT_TRUE(wait_until([&] { return request.stop.stop_requested(); }));
        return fail(ErrorCode::cancelled, "stopped");
      },
      errors.sink(), {1, 1});
  for (const std::uint32_t far : {50u, 100u, 150u}) {
    ASSERT_TRUE(wait_until([&] { return begun > 0; }));
    begun = 0;
    buffer.seek(far);
  }
  ASSERT_EQ(buffer.wait(kLong), FrameBuffer::State::ready);
  EXPECT_EQ(buffer.best()->index, 150u);
  EXPECT_TRUE(errors.seen().empty());
}

TEST(Pipeline, late_frames_are_shown_in_order_on_a_slow_machine) {
  constexpr std::uint32_t kAhead = 4, kNone = ~0u;
  FakeSource source(4000);
  FrameBuffer buffer(once(4000, kAhead));
  Errors errors;
  std::atomic<std::uint32_t> in_hand{kNone}, late_before{0};
  Pipeline pipeline(source, buffer,
                    [&](const FrameRequest& request, const FetchedFrame& fetched) {
                      in_hand = request.frame;
                      wait_until([&] { return request.frame < late_before; });
                      return prepare(request, fetched);
                    },
                    errors.sink(), {1, 1});
  std::uint32_t playhead = 0;
  for (int round = 0; round < 20; ++round) {
    ASSERT_TRUE(wait_until([&] { return in_hand != kNone && in_hand >= playhead; }));
    const std::uint32_t frame = in_hand;
    // By the time the frame is ready, the playhead and its window have moved past it.
    playhead += 2 * kAhead;
    buffer.advance(playhead);
    late_before = playhead;
    ASSERT_TRUE(wait_until([&] {
      const auto best = buffer.best();
      return best && best->index == frame;
    }));
  }
  late_before = kNone;
}

TEST(Pipeline, frames_are_prepared_for_the_current_mode) {
  FakeSource source(3);
  FrameBuffer buffer(once(3, 2));
  Errors errors;
  Pipeline pipeline(source, buffer,
                    [](const FrameRequest& request, const FetchedFrame& fetched) {
                      auto scene = prepare(request, fetched);
                      scene->cloud.positions.resize(request.mode == DrawMode::voxel ? 2 : 1);
                      return scene;
                    },
                    errors.sink(), {2, 2});
  for (int i = 0; i < 20; ++i) {
    const bool voxel = i % 2 == 0;
    buffer.make_again(voxel ? DrawMode::voxel : DrawMode::surfel);
    ASSERT_EQ(buffer.wait(kLong), FrameBuffer::State::ready);
    ASSERT_EQ(buffer.best()->cloud.size(), voxel ? 2u : 1u);
  }
}

/// Options for three layers that end at levels 7, 9 and 10.
FrameBuffer::Options layered(std::uint32_t frames, std::uint32_t ahead) {
  FrameBuffer::Options options = once(frames, ahead);
  options.levels = {7, 9, kWholeFrame};
  options.store_bytes = 1 << 20;
  return options;
}

/// Makes a frame as deep as its layers. Damaged layers do not decode.
Result<SceneFrame> prepare_layers(const FrameRequest& request, const FetchedFrame& fetched) {
  for (const FetchedLayer& layer : fetched.layers)
    if (layer.bytes.view()[0] != request.frame) return fail("damaged");
  SceneFrame scene;
  scene.index = request.frame;
  scene.layers = static_cast<std::uint32_t>(fetched.layers.size());
  const int deepest[] = {7, 9, kWholeFrame};
  scene.level = std::min(request.level, deepest[fetched.layers.size() - 1]);
  return scene;
}

TEST(Pipeline, layers_that_a_frame_lacks_are_fetched_once) {
  FakeSource source(3);
  source.layered = true;
  FrameBuffer buffer(layered(3, 2));
  buffer.set_level(7);
  Errors errors;
  Pipeline pipeline(source, buffer, prepare_layers, errors.sink(), {2, 2});
  ASSERT_EQ(buffer.wait(kLong, true), FrameBuffer::State::ready);
  EXPECT_EQ(buffer.best()->level, 7);
  ASSERT_TRUE(wait_until([&] { return buffer.held() == 3; }));
  buffer.set_level(8);
  for (const std::uint32_t frame : {0, 1, 2}) {
    buffer.advance(frame);
    ASSERT_EQ(buffer.wait(kLong, true), FrameBuffer::State::ready);
    EXPECT_EQ(buffer.best()->layers, 2u);
  }
  EXPECT_EQ(source.fetched_layers(), (std::multiset<std::uint32_t>{0, 0, 0, 1, 1, 1}));
  buffer.set_level(5);
  EXPECT_FALSE(wait_until([&] { return source.fetched_layers().size() > 6; }, kMoment));
}

TEST(Pipeline, a_damaged_layer_is_fetched_once_more) {
  FakeSource source(1);
  source.layered = true;
  source.damaged_layer = 1;
  FrameBuffer buffer(layered(1, 0));
  Errors errors;
  Pipeline pipeline(source, buffer, prepare_layers, errors.sink(), {2, 2});
  ASSERT_EQ(buffer.wait(kLong, true), FrameBuffer::State::ready);
  EXPECT_EQ(buffer.best()->layers, 3u);
  ASSERT_TRUE(wait_until([&] { return pipeline.refetched() == 1; }));
  EXPECT_EQ(pipeline.fetched_bytes(), 4u);
  EXPECT_TRUE(errors.seen().empty());
  EXPECT_EQ(source.fetched_layers(), (std::multiset<std::uint32_t>{0, 1, 1, 2}));
  EXPECT_EQ(source.fresh, 1);
}

TEST(Pipeline, a_frame_is_shown_without_a_layer_that_stays_damaged) {
  for (const std::uint32_t layer : {0u, 1u, 2u}) {
    FakeSource source(2);
    source.layered = true;
    source.damaged_layer = layer;
    source.damaged_always = true;
    FrameBuffer buffer(layered(2, 0));
    Errors errors;
    Pipeline pipeline(source, buffer, prepare_layers, errors.sink(), {2, 2});
    ASSERT_EQ(buffer.wait(kLong, true),
              layer == 0 ? FrameBuffer::State::failed : FrameBuffer::State::ready);
    if (layer > 0) {
      EXPECT_EQ(buffer.best()->layers, layer);
    }
    ASSERT_TRUE(wait_until([&] { return pipeline.errors() == 1; }));
    EXPECT_EQ(source.fetched_layers().count(layer), 2u);
    EXPECT_FALSE(wait_until(
        [&] { return source.fetched_layers().count(layer) > 2 || pipeline.errors() > 1; }, kMoment))
        << "it was fetched more than twice";
  }
}

TEST(Pipeline, scrubbing_shows_the_base_of_the_frame_under_the_cursor) {
  FakeSource source(200);
  source.layered = true;
  source.delay = std::chrono::microseconds(300);
  FrameBuffer::Options options = layered(200, 4);
  options.base_first = true;
  FrameBuffer buffer(options);
  Errors errors;
  Pipeline pipeline(source, buffer, prepare_layers, errors.sink(), {4, 2});
  std::mt19937 random(7);
  for (int i = 0; i < 200; ++i) {
    const auto cursor = static_cast<std::uint32_t>(random() % 200);
    buffer.scrub(cursor);
    if (i % 4 != 0) continue;
    ASSERT_EQ(buffer.wait(kLong), FrameBuffer::State::ready);
    ASSERT_EQ(buffer.best()->index, cursor);
    EXPECT_EQ(buffer.best()->layers, 1u);
    if (i % 40 != 0) continue;
    buffer.seek(cursor);
    ASSERT_EQ(buffer.wait(kLong, true), FrameBuffer::State::ready);
    EXPECT_EQ(buffer.best()->index, cursor);
    EXPECT_EQ(buffer.best()->layers, 3u);
  }
  EXPECT_TRUE(errors.seen().empty());
}

TEST(Pipeline, destruction_in_the_middle_of_work_reports_no_error) {
  Errors errors;
  for (int i = 0; i < 20; ++i) {
    FakeSource source(100);
    source.delay = std::chrono::microseconds(200);
    FrameBuffer buffer(once(100, 10));
    Pipeline pipeline(source, buffer, prepare, errors.sink(), {3, 3});
    // Each pipeline ends a little later, in the middle of some other step.
    std::this_thread::sleep_for(std::chrono::microseconds(150 * i));
  }
  EXPECT_TRUE(errors.seen().empty());
}

}  // namespace
}  // namespace pointreel::pipeline_test
