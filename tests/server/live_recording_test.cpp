// Live streams as packages: recordings on disk, and the newest segments for viewers over HTTP.

#include <fstream>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/file.h>

#include "codec/core/reel_rules.h"
#include "codec/live/live_sound.h"
#include "codec/package/manifest.h"
#include "common/file_system/descriptor.h"
#include "common/file_system/lock_folder.h"
#include "common/file_system/write_file.h"
#include "pointreel/chunks.h"
#include "pointreel/draco.h"
#include "pointreel/package.h"
#include "server/inspect/inspect.h"
#include "server/relay/http_window.h"
#include "server/relay/recorder.h"
#include "server/relay/segmenter.h"
#include "server/relay/sink_thread.h"
#include "tests/live_frames.h"
#include "tests/server/recorder_test.h"

namespace pointreel::live_recording_test {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

TEST_F(RecorderTest, a_recording_is_a_package_at_every_moment) {
  LiveRecorder recorder(options());
  recorder.hello(real_hello());
  for (std::uint32_t frame = 0; frame < 23; ++frame) {
    give(recorder, real_frame(frame));
    if (frame < 5) {
      EXPECT_FALSE(fs::exists(package() / kManifestName));
      continue;
    }
    std::uint32_t frames = 0;
    ASSERT_THAT(faults(package(), frames), IsEmpty()) << "after frame " << frame;
    EXPECT_EQ(frames, frame / 5 * 5);
    EXPECT_TRUE(read_manifest(package()).value().live) << "it grows";
  }
  recorder.end();
  std::uint32_t frames = 0;
  EXPECT_THAT(faults(package(), frames), IsEmpty());
  EXPECT_EQ(frames, 23u);
  const Manifest manifest = read_manifest(package()).value();
  EXPECT_FALSE(manifest.live);
  EXPECT_EQ(manifest.captured_us, kStart);
  EXPECT_EQ(frame_time_us(manifest, 7), 7 * kPeriod);
  EXPECT_EQ(manifest.duration_us, 23 * kPeriod);
  EXPECT_EQ(manifest.bounds, real_hello().bounds);
  EXPECT_THAT(said_, IsEmpty());
}

TEST_F(RecorderTest, a_destroyed_recorder_leaves_only_files_of_the_package) {
  {
    LiveRecorder recorder(options());
    recorder.hello(real_hello());
    give_frames(recorder, 0, 7);
  }
  std::uint32_t frames = 0;
  EXPECT_THAT(faults(package(), frames), IsEmpty());
  EXPECT_EQ(frames, 7u);
  EXPECT_FALSE(fs::exists(package() / ".unfinished"));
}

TEST_F(RecorderTest, a_returning_publisher_continues_its_package_and_another_starts_a_new_one) {
  LiveRecorder recorder(options());
  recorder.hello(real_hello(1));
  give_frames(recorder, 0, 4);
  recorder.end();
  recorder.hello(real_hello(1));
  give_frames(recorder, 4, 4);
  recorder.end();
  recorder.hello(real_hello(2));
  give_frames(recorder, 0, 3);
  recorder.end();
  std::uint32_t frames = 0;
  EXPECT_THAT(faults(package(), frames), IsEmpty());
  EXPECT_EQ(frames, 8u);
  EXPECT_THAT(faults(package("stage-2"), frames), IsEmpty());
  EXPECT_EQ(frames, 3u);
}

TEST_F(RecorderTest, sound_is_part_of_the_package_and_goes_on_when_the_publisher_returns) {
  constexpr std::uint8_t kSilence[]{0xfc, 0xff, 0xfe};
  LiveRecorder recorder(options());
  recorder.hello(real_hello(1));
  std::uint32_t number = 0;
  const auto give_sound = [&](std::uint64_t from_ms, std::uint64_t to_ms) {
    for (; from_ms < to_ms; from_ms += 20) {
      const auto bytes = std::make_shared<const Bytes>(
          write_live_sound({number++, kStart + 1000 * from_ms, 960, kSilence}));
      recorder.sound(parse_live_sound(*bytes).value(), {LiveMessage::Kind::binary, bytes});
    }
  };
  give_sound(0, 200);
  give_frames(recorder, 0, 8);
  give_sound(200, 320);
  recorder.end();
  std::uint32_t frames = 0;
  EXPECT_THAT(faults(package(), frames), IsEmpty());
  ASSERT_TRUE(read_manifest(package()).value().audio);
  EXPECT_EQ(read_manifest(package())->audio->samples, 16u * 960);
  recorder.hello(real_hello(1));
  give_frames(recorder, 8, 8);
  give_sound(400, 640);
  recorder.end();
  EXPECT_THAT(faults(package(), frames), IsEmpty());
  EXPECT_EQ(read_manifest(package())->audio->samples, 32u * 960);
  int files = 0;
  for (const auto& entry : fs::directory_iterator(package()))
    files += entry.path().extension() == ".opus";
  EXPECT_EQ(files, 1);
  // Another publisher, whose recording is silent.
  recorder.hello(real_hello(2));
  give_frames(recorder, 0, 3);
  recorder.end();
  EXPECT_THAT(faults(package("stage-2"), frames), IsEmpty());
  EXPECT_FALSE(read_manifest(package("stage-2")).value().audio);
}

TEST_F(RecorderTest, a_package_is_locked_until_its_publisher_has_left) {
  LiveRecorder recorder(options());
  const auto is_locked = [&] { return Descriptor(lock_folder(package(), LOCK_NB)).get() < 0; };
  recorder.hello(real_hello(1));
  give_frames(recorder, 0, 12);
  EXPECT_TRUE(is_locked());
  recorder.end();
  EXPECT_FALSE(is_locked());
  recorder.hello(real_hello(1));
  give_frames(recorder, 12, 12);
  EXPECT_TRUE(is_locked());
  recorder.end();
  std::uint32_t frames = 0;
  EXPECT_THAT(faults(package(), frames), IsEmpty());
  EXPECT_EQ(frames, 24u);
}

TEST_F(RecorderTest, what_was_changed_while_the_publisher_was_away_is_not_touched) {
  LiveRecorder recorder(options());
  recorder.hello(real_hello(1));
  give_frames(recorder, 0, 4);
  recorder.end();
  Manifest changed = read_manifest(package()).value();
  changed.name = "changed";
  ASSERT_TRUE(replace_file(package() / kManifestName, write_manifest(changed)));
  recorder.hello(real_hello(1));
  give_frames(recorder, 4, 4);
  recorder.end();
  // Another program writes to this one.
  const Descriptor lock(lock_folder(package("stage-2"), LOCK_NB));
  ASSERT_GE(lock.get(), 0);
  recorder.hello(real_hello(1));
  give_frames(recorder, 8, 3);
  recorder.end();
  std::uint32_t frames = 0;
  EXPECT_EQ(read_manifest(package())->name, "changed");
  for (const auto& [name, count] : {std::pair{"stage", 4u}, {"stage-2", 4u}, {"stage-3", 3u}}) {
    EXPECT_THAT(faults(package(name), frames), IsEmpty()) << name;
    EXPECT_EQ(frames, count) << name;
  }
}

TEST_F(RecorderTest, what_takes_the_place_of_a_growing_package_is_not_touched) {
  LiveRecorder recorder(options());
  recorder.hello(real_hello(1));
  give_frames(recorder, 0, 12);
  fs::rename(package(), package("moved"));
  fs::create_directory(package());
  give_frames(recorder, 12, 12);
  recorder.end();
  EXPECT_TRUE(fs::is_empty(package()));
  std::uint32_t moved = 0, next = 0;
  EXPECT_THAT(faults(package("moved"), moved), IsEmpty());
  EXPECT_THAT(faults(package("stage-2"), next), IsEmpty());
  EXPECT_EQ(moved + next, 24u);
}

TEST_F(RecorderTest, existing_packages_are_not_touched) {
  fs::create_directories(package());
  std::ofstream(package() / "mine") << "mine";
  LiveRecorder recorder(options());
  recorder.hello(real_hello());
  give_frames(recorder, 0, 3);
  recorder.end();
  EXPECT_THAT(contents(package()), SizeIs(1));
  EXPECT_TRUE(read_manifest(package("stage-2")));
}

TEST_F(RecorderTest, a_manifest_that_grows_too_long_continues_in_another_package) {
  LiveRecorderOptions small = options();
  small.manifest_bytes = 2'000;
  {
    LiveRecorder recorder(small);
    recorder.hello(real_hello());
    give_frames(recorder, 0, 60);
  }
  std::uint32_t all = 0, packages = 0;
  for (const auto& entry : fs::directory_iterator(package().parent_path())) {
    std::uint32_t frames = 0;
    EXPECT_THAT(faults(entry.path(), frames), IsEmpty()) << entry.path();
    EXPECT_FALSE(read_manifest(entry.path()).value().live);
    EXPECT_LT(fs::file_size(entry.path() / kManifestName), 5'000u);
    all += frames;
    ++packages;
  }
  EXPECT_GE(packages, 3u);
  EXPECT_EQ(all, 60u);
}

TEST_F(RecorderTest, an_incomplete_frame_is_recorded_as_far_as_it_arrived) {
  LiveRecorder recorder(options());
  recorder.hello(real_hello());
  auto cut = real_frame(0);
  ASSERT_GT(cut.size(), 1u);
  cut.pop_back();
  give(recorder, cut);
  give(recorder, real_frame(1));
  recorder.end();
  const Manifest manifest = read_manifest(package()).value();
  EXPECT_EQ(manifest.frame_count(), 2u);
  EXPECT_EQ(manifest.segments[0].layers[cut.size()].frames[0], Chunks<std::uint32_t>{});
  EXPECT_GT(total(manifest.segments[0].layers[cut.size()].frames[1]), 0u);
  EXPECT_TRUE(manifest.partial);
  std::uint32_t frames = 0;
  EXPECT_THAT(faults(package(), frames), IsEmpty()) << "a declared gap is not a fault";
}

TEST_F(RecorderTest, complete_frames_are_not_reported_as_incomplete) {
  LiveRecorder recorder(options());
  recorder.hello(real_hello());
  give_frames(recorder, 0, 8);
  recorder.end();
  EXPECT_FALSE(read_manifest(package()).value().partial);
}

TEST_F(RecorderTest, an_incomplete_last_frame_is_reported) {
  LiveRecorder recorder(options());
  recorder.hello(real_hello());
  give_frames(recorder, 0, 2);
  auto cut = real_frame(2);
  cut.pop_back();
  give(recorder, cut);
  recorder.end();
  EXPECT_TRUE(read_manifest(package()).value().partial);
  std::uint32_t frames = 0;
  EXPECT_THAT(faults(package(), frames), IsEmpty());
  EXPECT_EQ(frames, 3u);
}

TEST_F(RecorderTest, frames_in_different_cubes_share_a_segment_with_a_common_cube) {
  LiveRecorder recorder(options());
  recorder.hello(real_hello());
  give(recorder, real_frame(0));
  give(recorder, real_frame(1, 0.5));
  recorder.end();
  std::uint32_t frames = 0;
  EXPECT_THAT(faults(package(), frames), IsEmpty());
  const Cube cube = read_manifest(package()).value().segments[0].cube;
  EXPECT_EQ(cube.origin, glm::dvec3(-2.0));
  EXPECT_GE(cube.edge, 4.5);
}

TEST_F(RecorderTest, frames_that_no_package_can_hold_are_skipped) {
  LiveRecorder recorder(options());
  LiveHello hello = real_hello();
  hello.normals = false;
  recorder.hello(hello);
  give_frames(recorder, 0, 3);  // they have normals
  hello.normals = true;
  recorder.hello(hello);
  give(recorder, {layer_message(3, 0, 3, 10), layer_message(3, 1)});  // no frame at all
  give_frames(recorder, 4, 2);
  recorder.end();
  std::uint32_t frames = 0;
  EXPECT_THAT(faults(package(), frames), IsEmpty());
  EXPECT_EQ(frames, 2u);
}

TEST_F(RecorderTest, a_folder_that_cannot_be_written_is_reported_once_and_disturbs_nothing) {
  std::ofstream(temporary_.path() / "recordings") << "a file";
  LiveRecorder recorder(options());
  recorder.hello(real_hello());
  give_frames(recorder, 0, 20);
  EXPECT_THAT(said_, ElementsAre(HasSubstr("recording stage has stopped")));
  recorder.end();
  for (int second = 0; second < 3; ++second) EXPECT_FALSE(recorder.settle());
  EXPECT_THAT(said_, ElementsAre(HasSubstr("has stopped"), HasSubstr("20 frames wait")));
}

TEST_F(RecorderTest, frames_keep_their_pace_when_the_publishers_clock_is_set_back) {
  LiveRecorder recorder(options());
  recorder.hello(real_hello());
  for (std::uint32_t i = 0; i < 40; ++i) {
    const std::uint64_t set_back = i < 10 ? 0 : i < 20 ? 3'600'000'000 : 7'200'000'000;
    give_at(recorder, i, kStart + i * kPeriod - set_back);
  }
  recorder.end();
  const Manifest manifest = read_manifest(package()).value();
  for (std::uint32_t i = 0; i < 40; ++i) EXPECT_EQ(frame_time_us(manifest, i), i * kPeriod);
  EXPECT_THAT(manifest.segments, SizeIs(8));
}

TEST_F(RecorderTest, times_and_rates_of_any_size_give_a_package) {
  LiveRecorder recorder(options());
  LiveHello hello = real_hello();
  hello.fps = kMinFps;
  recorder.hello(hello);
  for (std::uint32_t i = 0; i < 20; ++i) give_at(recorder, i, i % 2 == 0 ? 0 : kMaxCaptureTime);
  recorder.end();
  std::uint32_t frames = 0;
  EXPECT_THAT(faults(package(), frames), IsEmpty());
  EXPECT_EQ(frames, 20u);
}

/// The files that a window has written.
struct Files {
  std::map<std::string, std::string> files;
  std::vector<std::string> changed;

  WindowOutput output() {
    WindowOutput output;
    output.put = [this](const std::string& name, std::string content, bool immutable) {
      if (immutable && files.contains(name)) changed.push_back(name);
      files[name] = std::move(content);
    };
    output.remove = [this](const std::string& name) { files.erase(name); };
    return output;
  }
  Manifest manifest() const { return parse_manifest(files.at(kManifestName)).value(); }
  /// Whether every file of the manifest exists with its size and checksum.
  bool whole(const Manifest& manifest) const {
    for (const PackageFile* file : manifest.files()) {
      const auto found = files.find(file->path);
      if (found == files.end() || found->second.size() != file->bytes ||
          checksum_of({reinterpret_cast<const std::uint8_t*>(found->second.data()),
                       found->second.size()}) != file->checksum) {
        return false;
      }
    }
    return true;
  }
};

WindowOptions small_window() {
  WindowOptions options;
  options.segment_us = 5 * kPeriod;
  options.segments = 3;
  return options;
}

TEST(HttpWindow, is_a_package_of_the_newest_segments_with_its_position_in_the_stream) {
  Files out;
  HttpWindow window(out.output(), small_window());
  window.hello(real_hello(77));
  give_frames(window, 0, 41);
  const Manifest manifest = out.manifest();
  EXPECT_TRUE(out.whole(manifest));
  EXPECT_EQ(manifest.frame_count(), 15u);
  ASSERT_TRUE(manifest.live);
  EXPECT_EQ(manifest.live->session, 77u);
  EXPECT_EQ(manifest.live->first_frame, 25u);
  EXPECT_EQ(manifest.live->start_us, kStart + 25 * kPeriod);
  EXPECT_FALSE(manifest.live->ended);
  EXPECT_EQ(manifest.segments[0].times_us[0], 0u);
  EXPECT_EQ(frame_time_us(manifest, 14), 14 * kPeriod);
}

TEST(HttpWindow, keeps_files_of_recent_manifests_within_bounded_memory) {
  Files out;
  HttpWindow window(out.output(), small_window());
  window.hello(real_hello());
  give_frames(window, 0, 16);
  const Manifest old = out.manifest();
  give_frames(window, 16, 15);
  EXPECT_TRUE(out.whole(old)) << "the files last for three more segments";
  give_frames(window, 31, 300);
  EXPECT_LE(out.files.size(), 1u + 2 * 3 * 3) << "at most twice the manifest's segments";
  EXPECT_THAT(out.changed, IsEmpty()) << "a file never changes under its name";
}

TEST(HttpWindow, has_the_sound_that_came_during_each_segment) {
  Files out;
  HttpWindow window(out.output(), small_window());
  window.hello(real_hello());
  const auto give_sound = [&](std::uint32_t number, std::size_t size = 3) {
    const Bytes packet(size, 1);
    LiveSound sound{number, kStart, 960, packet};
    const auto bytes = std::make_shared<const Bytes>(write_live_sound(sound));
    window.sound(sound, {LiveMessage::Kind::binary, bytes});
  };
  const auto numbers = [&](const Segment& segment) {
    std::vector<std::uint32_t> all;
    const std::string& text = out.files.at(segment.sound.value().path);
    const Bytes file(text.begin(), text.end());
    const auto sounds = parse_live_sound_file(file).value();
    for (const LiveSound& sound : sounds) all.push_back(sound.number);
    return all;
  };
  give_sound(0);
  give_frames(window, 0, 3);
  give_sound(1);
  give_frames(window, 3, 8);
  give_sound(2);
  window.end();
  const Manifest manifest = out.manifest();
  EXPECT_TRUE(out.whole(manifest));
  ASSERT_EQ(manifest.segments.size(), 3u);
  EXPECT_EQ(numbers(manifest.segments[0]), (std::vector<std::uint32_t>{0, 1}));
  EXPECT_FALSE(manifest.segments[1].sound);
  EXPECT_EQ(numbers(manifest.segments[2]), (std::vector<std::uint32_t>{2}));

  // While no frame comes, sound takes no more memory than a file may.
  window.hello(real_hello());
  for (std::uint32_t i = 0; i < 1000; ++i) give_sound(i, 2000);
  give_frames(window, 11, 6);
  const Manifest newest = out.manifest();
  EXPECT_LE(newest.segments.back().sound.value().bytes, kMaxSegmentSoundBytes);
  EXPECT_EQ(numbers(newest.segments.back()).back(), 999u);
  give_frames(window, 17, 24);
  window.end();
  const Manifest later = out.manifest();
  EXPECT_TRUE(out.whole(later));
  EXPECT_EQ(out.changed, std::vector<std::string>());
  give_frames(window, 41, 50);
  EXPECT_LE(out.files.size(), 1u + 2 * 3 * 3) << "files of sound go with their segments";
}

TEST(HttpWindow, reports_that_the_publisher_has_left_and_resumes_when_it_returns) {
  Files out;
  HttpWindow window(out.output(), small_window());
  window.hello(real_hello());
  give_frames(window, 0, 7);
  window.end();
  EXPECT_TRUE(out.manifest().live->ended);
  EXPECT_EQ(out.manifest().frame_count(), 7u) << "the last frame is included";
  window.hello(real_hello());
  give_frames(window, 7, 6);
  EXPECT_FALSE(out.manifest().live->ended);
  EXPECT_EQ(out.manifest().frame_count(), 12u);
}

TEST(HttpWindow, the_manifest_of_a_session_is_whole_until_the_next_has_a_segment) {
  Files out;
  HttpWindow window(out.output(), small_window());
  window.hello(real_hello(1));
  give_frames(window, 0, 20);
  window.end();
  window.hello(real_hello(2));
  give_frames(window, 0, 4);
  const Manifest old = out.manifest();
  EXPECT_EQ(old.live->session, 1u);
  EXPECT_TRUE(old.live->ended);
  EXPECT_TRUE(out.whole(old));
  give_frames(window, 4, 2);
  EXPECT_EQ(out.manifest().live->session, 2u);
  EXPECT_EQ(out.manifest().live->first_frame, 0u);
  EXPECT_TRUE(out.whole(out.manifest())) << "files of the same name in both sessions stay";
  EXPECT_TRUE(out.whole(old)) << "a cache may still have the old manifest";
  give_frames(window, 6, 14);
  EXPECT_TRUE(out.whole(out.manifest()));
  EXPECT_LE(out.files.size(), 1u + 2 * 3 * 3);
}

TEST(HttpWindow, removes_everything_at_the_end) {
  Files out;
  {
    HttpWindow window(out.output(), small_window());
    window.hello(real_hello(1));
    give_frames(window, 0, 40);
    window.hello(real_hello(2));
    give_frames(window, 0, 6);
  }
  EXPECT_THAT(out.files, IsEmpty());
}

TEST(HttpWindow, has_fewer_segments_if_they_are_large) {
  Files out;
  WindowOptions options = small_window();
  options.bytes = 1;
  HttpWindow window(out.output(), options);
  window.hello(real_hello());
  give_frames(window, 0, 30);
  EXPECT_THAT(out.manifest().segments, SizeIs(1));
}

/// A sink that blocks until the test releases it.
class HeldSink : public LiveSink {
 public:
  HeldSink(std::mutex& gate, std::vector<std::string>& notes) : gate_(gate), notes_(notes) {}
  void hello(const LiveHello&) override { note("hello"); }
  void layer(const LiveLayer&, const LiveMessage& message) override { note(brief(message)); }
  void end() override { note("end"); }

 private:
  void note(std::string what) {
    const std::lock_guard lock(gate_);
    notes_.push_back(std::move(what));
  }
  std::mutex& gate_;
  std::vector<std::string>& notes_;
};

TEST(SinkThread, forwards_everything_in_order_without_blocking_its_caller) {
  std::mutex gate;
  std::vector<std::string> notes, said;
  {
    SinkThread thread(std::make_unique<HeldSink>(gate, notes), "recorded", {});
    const std::lock_guard held(gate);
    thread.hello(plain_hello());
    give(thread, {layer_message(0, 0), layer_message(0, 1)});
    thread.end();
    EXPECT_THAT(notes, IsEmpty());
  }
  EXPECT_THAT(notes, ElementsAre("hello", "0.0", "0.1", "end"));
}

TEST(SinkThread, skips_the_rest_of_a_frame_if_the_sink_is_too_slow_and_reports_it) {
  std::mutex gate;
  std::vector<std::string> notes, said;
  {
    SinkThread thread(
        std::make_unique<HeldSink>(gate, notes), "recorded",
        [&](const std::string& line) { said.push_back(line); },
        2 * SinkThread::kLayerOverhead + 25);
    const std::lock_guard held(gate);
    thread.hello(plain_hello());
    give(thread,
         {layer_message(0, 0, 3, 10), layer_message(0, 1, 3, 10), layer_message(0, 2, 3, 10)});
    give(thread, {layer_message(1, 0, 3, 20), layer_message(1, 1, 3, 1)});
  }
  EXPECT_THAT(notes, ElementsAre("hello", "0.0", "0.1"));
  EXPECT_THAT(said, ElementsAre(HasSubstr("frame 0 is not recorded"), HasSubstr("frame 1")));
}

TEST(SinkThread, counts_more_than_the_bytes_of_tiny_layers) {
  std::mutex gate;
  std::vector<std::string> notes;
  {
    SinkThread thread(std::make_unique<HeldSink>(gate, notes), "recorded", {},
                      10 * SinkThread::kLayerOverhead);
    const std::lock_guard held(gate);
    for (std::uint32_t frame = 0; frame < 1000; ++frame) {
      give(thread, {layer_message(frame, 0, 1, 1)});
    }
  }
  EXPECT_GE(notes.size(), 9u);
  EXPECT_LE(notes.size(), 11u) << "one more may have been taken out before the gate was held";
}

}  // namespace
}  // namespace pointreel::live_recording_test
