#include <algorithm>
#include <atomic>
#include <chrono>
#include <map>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "client/source/live_pacing.h"
#include "client/source/open_live_source.h"
#include "codec/live/live.h"
#include "codec/live/live_sound.h"
#include "codec/package/manifest.h"
#include "pointreel/package.h"
#include "tests/scripted_http_server.h"
#include "tests/wait.h"

namespace pointreel::http_live_source_test {
namespace {

using namespace std::chrono_literals;

constexpr auto kLong = std::chrono::milliseconds(60'000);

/// A stream that is published segment by segment. Segments have two frames, 10 ms apart, with
/// layers of 4 and 6 bytes. Every byte is the number of the frame.
class Stage {
 public:
  /// The manifest lists this many segments, the newest.
  explicit Stage(std::size_t listed = 2)
      : listed_(listed),
        server_([this](int socket, const std::string& head) { return serve(socket, head); }) {
    begin(1);
  }

  std::string url() const { return server_.url() + "/live/stage/reel.json"; }

  void begin(std::uint64_t session, std::uint64_t start_us = 5'000'000) {
    const std::lock_guard lock(mutex_);
    ++version_;
    manifest_ = Manifest{};
    manifest_.name = "stage";
    manifest_.codec = "octree";
    manifest_.entropy = "none";
    manifest_.fps = 100.0;
    manifest_.colors = true;
    manifest_.depth_max = 9;
    manifest_.layer_names = {"base", "full"};
    manifest_.bounds.grow(glm::dvec3(0.0));
    manifest_.bounds.grow(glm::dvec3(1.0));
    manifest_.live = LiveManifest{session, 0, start_us, false};
  }

  /// Publishes a segment. `sound` is the file of its sound, if it has any, which may be served with
  /// its last byte damaged.
  void publish_segment(const std::string& sound = "", bool damaged = false) {
    const std::lock_guard lock(mutex_);
    const std::uint32_t first = frames_of(manifest_);
    Segment segment;
    segment.first_frame = first;
    segment.cube = {glm::dvec3(0.0), 1.0};
    const auto number = [&](std::uint32_t i) {
      return static_cast<char>(manifest_.live->first_frame + first + i);
    };
    for (const auto& [name, size] : {std::pair{"base", 4u}, std::pair{"full", 6u}}) {
      const std::string content = std::string(size, number(0)) + std::string(size, number(1));
      LayerFile file;
      file.path = fmt::format("{}.{}.{}.prs", manifest_.live->session,
                              manifest_.live->first_frame + first, name);
      file.bytes = content.size();
      file.checksum =
          checksum_of({reinterpret_cast<const std::uint8_t*>(content.data()), content.size()});
      file.frames.assign(2, {size - 1, 1, 0});
      files_[file.path] = content;
      segment.layers.push_back(std::move(file));
    }
    if (!sound.empty()) {
      segment.sound = PackageFile{
          fmt::format("{}.sound.prs", manifest_.live->first_frame + first), sound.size(),
          checksum_of({reinterpret_cast<const std::uint8_t*>(sound.data()), sound.size()})};
      files_[segment.sound->path] = sound;
      if (damaged) files_[segment.sound->path].back() ^= 1;
    }
    const std::uint64_t begin = first * 10'000ull + silence_us_;
    segment.times_us = {begin, begin + 10'000};
    segment.points = {1, 1};
    manifest_.segments.push_back(std::move(segment));
    if (manifest_.segments.size() > listed_) {
      // Frame numbers and times are relative to the first listed frame.
      manifest_.segments.erase(manifest_.segments.begin());
      manifest_.live->first_frame += 2;
      manifest_.live->start_us += 20'000;
      for (Segment& each : manifest_.segments) {
        each.first_frame -= 2;
        for (std::uint64_t& time : each.times_us) time -= 20'000;
      }
    }
    manifest_.duration_us = manifest_.segments.back().times_us.back() + 10'000;
    ++version_;
  }

  /// The next segment begins so much later than the one before it ends.
  void be_silent(std::uint64_t us) { silence_us_ += us; }

  /// Until `work` is done, serves the manifest of before, as a cache does.
  template <class Work>
  void hold_back(const Work& work) {
    {
      const std::lock_guard lock(mutex_);
      held_ = Served{write_manifest(manifest_), version_};
    }
    work();
    const std::lock_guard lock(mutex_);
    held_.reset();
  }

  void end() {
    const std::lock_guard lock(mutex_);
    manifest_.live->ended = true;
    ++version_;
  }

  std::atomic<int> not_modified{0}, sounds_served{0};
  std::atomic<std::chrono::milliseconds> delay{0ms};  ///< of files
  std::atomic<bool> gone{false};

 private:
  static std::uint32_t frames_of(const Manifest& manifest) { return manifest.frame_count(); }

  bool serve(int socket, const std::string& head) {
    const std::lock_guard lock(mutex_);
    const std::string path = head.substr(4, head.find(' ', 4) - 4);
    const std::string name = path.substr(path.rfind('/') + 1);
    const Served served =
        held_ ? *held_ : Served{name == "reel.json" ? write_manifest(manifest_) : "", version_};
    const std::string tag = fmt::format("\"{}\"", served.version);
    if (gone) {
      answer(socket, "404 Not Found", "", "nobody");
    } else if (name == "reel.json" && head.find("If-None-Match: " + tag) != std::string::npos) {
      ++not_modified;
      send_text(socket, "HTTP/1.1 304 Not Modified\r\nETag: " + tag + "\r\n\r\n");
    } else if (name == "reel.json") {
      answer(socket, "200 OK", "ETag: " + tag + "\r\n", served.manifest);
    } else if (files_.contains(name)) {
      if (name.ends_with(".sound.prs")) ++sounds_served;
      std::this_thread::sleep_for(delay.load());
      answer(socket, "200 OK", "", files_[name]);
    } else {
      answer(socket, "404 Not Found", "", "gone");
    }
    return true;
  }

  struct Served {
    std::string manifest;
    int version = 0;
  };

  const std::size_t listed_;
  std::mutex mutex_;
  Manifest manifest_;
  std::uint64_t silence_us_ = 0;
  std::optional<Served> held_;
  std::map<std::string, std::string> files_;
  int version_ = 0;
  ScriptedHttpServer server_;
};

std::unique_ptr<LiveSource> open(const std::string& url, bool sound = false) {
  SourceOptions options;
  options.sound = sound;
  options.first_backoff = std::chrono::milliseconds(1);
  auto source = open_live_source(url, options);
  EXPECT_TRUE(source) << source.error().message;
  return std::move(*source);
}

/// Returns the frame of that number in the session and skips those before it.
std::optional<LiveFrame> await(LiveSource& source, std::uint32_t number) {
  while (auto frame = source.next(kLong))
    if (frame->capture_us >= 5'000'000u + 10'000u * number) return frame;
  return std::nullopt;
}

TEST(HttpLiveSource, gives_the_frames_of_segments_as_they_are_listed) {
  Stage stage;
  stage.publish_segment();
  const auto source = open(stage.url());
  const auto hello = source->hello(kLong);
  ASSERT_TRUE(hello);
  EXPECT_EQ(hello->session, 1u);
  EXPECT_EQ(hello->layer_names.size(), 2u);
  const auto frame = await(*source, 1);
  ASSERT_TRUE(frame) << source->trouble().value_or("");
  EXPECT_EQ(frame->number, 1u);
  EXPECT_EQ(frame->capture_us, 5'010'000u);
  ASSERT_EQ(frame->frame.layers.size(), 2u);
  EXPECT_EQ(frame->frame.layers[0].bytes, Bytes(4, 1));
  EXPECT_EQ(frame->frame.layers[1].bytes, Bytes(6, 1));
  EXPECT_EQ(frame->frame.layers[1].sizes.geometry, 5u);
  for (int i = 0; i < 3; ++i) stage.publish_segment();
  const auto later = await(*source, 7);
  ASSERT_TRUE(later);
  EXPECT_GT(later->number, frame->number);
  EXPECT_EQ(later->capture_us, 5'070'000u);
  EXPECT_EQ(later->frame.layers[0].bytes, Bytes(4, 7));
}

TEST(HttpLiveSource, shows_all_frames_of_segments_that_a_cache_held_back) {
  Stage stage(6);
  stage.publish_segment();
  const auto source = open(stage.url());
  ASSERT_TRUE(await(*source, 1));
  const auto skipped = source->counts().skipped;
  stage.hold_back([&] {
    for (int i = 0; i < 4; ++i) stage.publish_segment();
  });
  std::set<std::uint64_t> shown;
  while (!shown.contains(5'090'000)) {
    const auto frame = source->next(kLong);
    ASSERT_TRUE(frame);
    shown.insert(frame->capture_us);
  }
  // A machine that is busy may skip some, and says so.
  EXPECT_EQ(shown.size() + source->counts().skipped - skipped, 8u);
}

TEST(HttpLiveSource, leaves_out_and_counts_segments_that_are_too_late) {
  Stage stage(6);
  stage.publish_segment();
  const auto source = open(stage.url());
  ASSERT_TRUE(await(*source, 1));
  stage.hold_back([&] {
    stage.publish_segment();
    stage.publish_segment();
    stage.be_silent(3'000'000);
    stage.publish_segment();
  });
  const auto frame = source->next(kLong);
  ASSERT_TRUE(frame);
  EXPECT_GE(frame->capture_us, 8'060'000u);
  EXPECT_GE(source->counts().skipped, 4u);
}

/// A file with one packet.
std::string sound_file(std::uint32_t number) {
  const Bytes packet{1, 2, 3};
  std::string file;
  append_live_sound(file, write_live_sound({number, 5'000'000 + 20'000u * number, 960, packet}));
  return file;
}

TEST(HttpLiveSource, gives_the_sound_of_segments_to_whoever_asks_for_it) {
  Stage stage;
  const auto source = open(stage.url(), true);
  std::mutex mutex;
  std::vector<std::uint32_t> heard;
  source->set_on_sound([&](const LiveSound& sound) {
    const std::lock_guard lock(mutex);
    heard.push_back(sound.number);
  });
  stage.publish_segment(sound_file(0));
  ASSERT_TRUE(await(*source, 1));
  EXPECT_EQ(source->counts().bad, 0u);
  // What is damaged is silence, and its pictures are shown.
  stage.publish_segment(sound_file(1), true);
  ASSERT_TRUE(await(*source, 3));
  EXPECT_EQ(source->counts().bad, 1u);
  stage.publish_segment(sound_file(2));
  ASSERT_TRUE(await(*source, 5));
  const std::lock_guard lock(mutex);
  EXPECT_EQ(heard, (std::vector<std::uint32_t>{0, 2}));
}

TEST(HttpLiveSource, gives_sound_with_the_layers_for_which_there_is_time) {
  Stage stage;
  stage.delay = 50ms;  // longer than a segment
  const auto source = open(stage.url(), true);
  std::atomic<int> heard = 0;
  source->set_on_sound([&](const LiveSound&) { ++heard; });
  stage.publish_segment(sound_file(0));
  ASSERT_TRUE(await(*source, 1));
  stage.publish_segment(sound_file(1));
  const auto frame = await(*source, 3);
  ASSERT_TRUE(frame);
  ASSERT_EQ(frame->frame.layers.size(), 1u);
  EXPECT_EQ(frame->frame.layers[0].bytes, Bytes(4, 3));
  EXPECT_EQ(source->counts().bad, 0u);
  EXPECT_EQ(heard, 2);
}

TEST(HttpLiveSource, fetches_no_sound_that_nobody_asks_for) {
  Stage stage;
  stage.publish_segment(sound_file(0));
  const auto source = open(stage.url());
  ASSERT_TRUE(await(*source, 1));
  EXPECT_EQ(stage.sounds_served, 0);
}

TEST(HttpLiveSource, continues_the_frame_numbers_when_the_server_restarts_its_own) {
  Stage stage;
  for (int i = 0; i < 5; ++i) stage.publish_segment();
  const auto source = open(stage.url());
  const auto before = await(*source, 9);
  ASSERT_TRUE(before);
  stage.begin(1, 5'100'000);
  stage.publish_segment();
  const auto frame = source->next(kLong);
  ASSERT_TRUE(frame);
  EXPECT_GT(frame->number, before->number);
  EXPECT_GE(frame->capture_us, 5'100'000u);
}

TEST(HttpLiveSource, polls_the_manifest_with_conditional_requests) {
  Stage stage;
  stage.publish_segment();
  const auto source = open(stage.url());
  ASSERT_TRUE(await(*source, 1));
  EXPECT_TRUE(wait_until([&] { return stage.not_modified > 0; }));
}

TEST(HttpLiveSource, starts_over_with_another_publisher) {
  Stage stage;
  for (int i = 0; i < 5; ++i) stage.publish_segment();
  const auto source = open(stage.url());
  ASSERT_TRUE(await(*source, 9));
  stage.begin(2);
  stage.publish_segment();
  const auto frame = source->next(kLong);
  ASSERT_TRUE(frame);
  EXPECT_LE(frame->number, 1u);
  EXPECT_EQ(source->hello(kLong)->session, 2u);
}

TEST(HttpLiveSource, reports_that_the_publisher_has_left_or_is_absent) {
  Stage stage;
  stage.publish_segment();
  const auto source = open(stage.url());
  ASSERT_TRUE(await(*source, 1));
  const auto hears = [&](const char* what) {
    std::string said;
    EXPECT_TRUE(wait_until([&] {
      said = source->trouble().value_or("");
      return said.find(what) != std::string::npos;
    })) << said;
  };
  stage.end();
  hears("has gone");
  stage.gone = true;
  hears("404");
}

TEST(HttpLiveSource, cancelling_ends_its_waits) {
  Stage stage;
  const auto source = open(stage.url());
  std::thread waiting([&] { EXPECT_FALSE(source->next(kLong)); });
  source->cancel();
  waiting.join();
}

TEST(LivePacing, keeps_the_capture_intervals_delayed_by_the_slowest_recent_segment) {
  LivePacing pacing;
  const LivePacing::Time begin{1'000s};
  pacing.arrived(0, begin + 100ms);
  EXPECT_EQ(pacing.due(20'000), begin + 120ms);
  pacing.arrived(500'000, begin + 900ms);  // 300 ms later than the first
  EXPECT_EQ(pacing.due(500'000), begin + 900ms);
  EXPECT_EQ(pacing.due(520'000), begin + 920ms);
  for (std::uint64_t i = 2; i < 30; ++i) pacing.arrived(500'000 * i, begin + 500ms * i + 100ms);
  EXPECT_EQ(pacing.due(15'000'000), begin + 15'100ms) << "the slow arrivals are forgotten";
}

TEST(LivePacing, begins_anew_when_the_publishers_clock_jumps) {
  LivePacing pacing;
  const LivePacing::Time begin{10'000s};
  pacing.arrived(5'000'000'000, begin);
  pacing.arrived(8'600'500'000, begin + 500ms);  // an hour ahead
  EXPECT_EQ(pacing.due(8'600'500'000), begin + 500ms);
  pacing.arrived(1'000'000, begin + 1s);  // far back
  EXPECT_EQ(pacing.due(1'000'000), begin + 1s);
}

}  // namespace
}  // namespace pointreel::http_live_source_test
