// Recordings on disks that fill up, in folders that others use too, and after a crash.

#include <fstream>
#include <random>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "codec/package/manifest.h"
#include "server/relay/recorded_package.h"
#include "tests/full_disk.h"
#include "tests/server/recorder_test.h"

namespace pointreel::recording_faults_test {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

/// How many bytes this process has written so far.
std::uint64_t bytes_written() {
  std::ifstream in("/proc/self/io");
  for (std::string name; in >> name;) {
    std::uint64_t value = 0;
    in >> value;
    if (name == "wchar:") return value;
  }
  ADD_FAILURE() << "/proc/self/io cannot be read";
  return 0;
}

std::uint64_t bytes_of(const fs::path& folder) {
  std::uint64_t bytes = 0;
  for (const auto& entry : fs::directory_iterator(folder)) bytes += entry.file_size();
  return bytes;
}

class RecordingFaultsTest : public RecorderTest {
 protected:
  /// A recording with a segment for each frame.
  LiveRecorderOptions short_segments() {
    LiveRecorderOptions short_ones = options();
    short_ones.segment_us = 1;
    return short_ones;
  }

  /// Gives small frames, quickly made.
  void give_small(LiveRecorder& recorder, std::uint32_t first, std::uint32_t count) {
    static const std::vector<LiveMessage> frame = real_frame(0);
    for (std::uint32_t i = first; i < first + count; ++i) {
      for (const LiveMessage& message : frame) {
        LiveLayer layer = parse_live_layer(*message.bytes).value();
        layer.frame = i;
        layer.capture_us = kStart + i * kPeriod;
        recorder.layer(layer, message);
      }
    }
  }

  fs::path journal() const { return package() / kJournalName; }
  /// Gives frames until the journal holds a few. Returns how many frames were given.
  std::uint32_t give_until_journal(LiveRecorder& recorder, std::uint64_t bytes) {
    std::uint32_t given = 0;
    while (given < 2'000 && (!fs::exists(journal()) || fs::file_size(journal()) < bytes)) {
      give_small(recorder, given++, 1);
    }
    EXPECT_TRUE(fs::exists(journal()));
    return given;
  }
  /// What a program that is killed now would leave behind.
  fs::path copy_as_if_killed(const std::string& name) {
    fs::create_directories(temporary_ / "killed");
    const fs::path copy = temporary_ / "killed" / name;
    fs::copy(package(), copy);
    return copy;
  }
};

TEST_F(RecordingFaultsTest, a_recording_continues_in_its_package_when_there_is_room_again) {
  for (const rlim_t room : {0, 1, 100, 300, 700, 1'500}) {
    said_.clear();
    LiveRecorderOptions named = options();
    named.name = "room-" + std::to_string(room);
    named.waiting_bytes = 0;
    std::uint32_t frames = 0;
    {
      LiveRecorder recorder(named);
      recorder.hello(real_hello());
      give_frames(recorder, 0, 15);
      {
        const FullDisk full(room);
        for (std::uint32_t i = 15; i < 35; ++i) {
          give(recorder, real_frame(i));
          ASSERT_THAT(faults(package(named.name), frames), IsEmpty());
          ASSERT_EQ(frames, 10u);
          ASSERT_FALSE(fs::exists(package(named.name) / ".unfinished")) << "it takes room";
        }
      }
      give_frames(recorder, 35, 20);
      recorder.end();
    }
    EXPECT_THAT(faults(package(named.name), frames), IsEmpty());
    EXPECT_EQ(frames, 55u - 20u) << "all but those that came while the disk was full";
    const Manifest manifest = read_manifest(package(named.name)).value();
    EXPECT_EQ(frame_time_us(manifest, 10), 30 * kPeriod) << "the gap remains in the times";
    EXPECT_EQ(contents(package(named.name)).size(), 1 + manifest.files().size());
    EXPECT_THAT(said_, ElementsAre(AllOf(HasSubstr("cannot be written"), HasSubstr("has stopped")),
                                   HasSubstr("continues; 20 frames are lost")));
  }
}

TEST_F(RecordingFaultsTest, nothing_is_lost_if_there_is_soon_room_again) {
  for (const rlim_t room : {0, 300, 1'500}) {
    said_.clear();
    LiveRecorderOptions named = options();
    named.name = "room-" + std::to_string(room);
    {
      LiveRecorder recorder(named);
      recorder.hello(real_hello());
      give_frames(recorder, 0, 15);
      {
        const FullDisk full(room);
        give_frames(recorder, 15, 20);
      }
      give_frames(recorder, 35, 20);
    }
    std::uint32_t frames = 0;
    EXPECT_THAT(faults(package(named.name), frames), IsEmpty());
    EXPECT_EQ(frames, 55u);
    EXPECT_EQ(frame_time_us(read_manifest(package(named.name)).value(), 54), 54 * kPeriod);
    EXPECT_THAT(said_, ElementsAre(HasSubstr("has stopped"), HasSubstr("0 frames are lost")));
  }
}

TEST_F(RecordingFaultsTest,
       what_waits_when_the_publisher_goes_is_written_when_there_is_room_again) {
  LiveRecorder recorder(options());
  recorder.hello(real_hello());
  give_frames(recorder, 0, 15);
  {
    const FullDisk full(100);
    give_frames(recorder, 15, 20);
    recorder.end();
    EXPECT_FALSE(recorder.settle());
  }
  EXPECT_TRUE(recorder.settle());
  std::uint32_t frames = 0;
  EXPECT_THAT(faults(package(options().name), frames), IsEmpty());
  EXPECT_EQ(frames, 35u);
  EXPECT_TRUE(recorder.settle());
  EXPECT_THAT(said_, ElementsAre(HasSubstr("has stopped"), HasSubstr("frames wait until"),
                                 HasSubstr("reel.json: cannot be written"),
                                 HasSubstr("continues; 0 frames are lost")));
}

TEST_F(RecordingFaultsTest, what_could_not_be_written_until_the_end_is_counted) {
  {
    LiveRecorder recorder(options());
    recorder.hello(real_hello());
    give_frames(recorder, 0, 12);
    const FullDisk full(0);
    give_frames(recorder, 12, 11);
    recorder.end();
    recorder.hello(real_hello(2));
  }
  std::uint32_t frames = 0;
  EXPECT_THAT(faults(package(), frames), IsEmpty());
  EXPECT_EQ(frames, 10u);
  ASSERT_FALSE(said_.empty());
  EXPECT_THAT(said_.back(), HasSubstr("its last 13 frames are lost"));
}

TEST_F(RecordingFaultsTest, a_disk_that_is_full_from_the_beginning_leaves_no_empty_packages) {
  LiveRecorderOptions impatient = options();
  impatient.waiting_bytes = 0;
  LiveRecorder recorder(impatient);
  recorder.hello(real_hello());
  {
    const FullDisk full(100);
    give_frames(recorder, 0, 23);
    EXPECT_THAT(contents(package().parent_path()), IsEmpty());
  }
  give_frames(recorder, 23, 7);
  recorder.end();
  std::uint32_t frames = 0;
  EXPECT_THAT(faults(package(), frames), IsEmpty());
  EXPECT_EQ(frames, 10u);
  EXPECT_EQ(read_manifest(package()).value().segments[0].times_us[0], 0u);
}

TEST_F(RecordingFaultsTest, a_line_of_the_journal_that_was_cut_off_does_no_harm) {
  LiveRecorder recorder(short_segments());
  recorder.hello(real_hello());
  const std::uint32_t given = give_until_journal(recorder, 4'000);
  const std::uint32_t before = read_manifest(package()).value().frame_count();
  EXPECT_EQ(before, given - 1);
  {
    const FullDisk full(fs::file_size(journal()) + 100);
    give_small(recorder, given, 2);
    EXPECT_EQ(read_manifest(package()).value().frame_count(), before);
  }
  give_small(recorder, given + 2, 3);
  EXPECT_EQ(read_manifest(package()).value().frame_count(), before + 5);
  std::uint32_t frames = 0;
  EXPECT_THAT(faults(package(), frames), IsEmpty());

  const fs::path copy = copy_as_if_killed("cut");
  std::ofstream(copy / kJournalName, std::ios::app) << "{\"segments\":[{\"first_fr";
  EXPECT_EQ(read_manifest(copy).value().frame_count(), before + 5);
  std::ofstream(copy / kJournalName, std::ios::app) << "\n";
  const auto damaged = read_manifest(copy);
  ASSERT_FALSE(damaged);
  EXPECT_THAT(damaged.error().message, HasSubstr("reel.journal: line"));
}

TEST_F(RecordingFaultsTest, what_has_the_recordings_name_already_is_not_touched) {
  fs::create_directories(package());
  std::ofstream(package("stage-2")) << "a file";
  fs::create_symlink("nowhere", package("stage-3"));
  fs::create_symlink("stage-3", package("stage-4"));
  fs::remove(package());
  std::ofstream(package()) << "another file";
  {
    LiveRecorder recorder(options());
    recorder.hello(real_hello());
    give_frames(recorder, 0, 7);
  }
  std::uint32_t frames = 0;
  EXPECT_THAT(faults(package("stage-5"), frames), IsEmpty());
  EXPECT_EQ(frames, 7u);
  EXPECT_TRUE(fs::is_regular_file(package()));
  EXPECT_FALSE(fs::exists(package().parent_path() / "nowhere"));
  EXPECT_THAT(said_, IsEmpty());
}

TEST_F(RecordingFaultsTest, a_package_that_is_removed_is_followed_by_another) {
  LiveRecorder recorder(options());
  recorder.hello(real_hello());
  give_frames(recorder, 0, 12);
  fs::rename(package(), temporary_ / "moved");
  give_frames(recorder, 12, 12);
  recorder.end();
  std::uint32_t frames = 0;
  EXPECT_THAT(faults(temporary_ / "moved", frames), IsEmpty());
  EXPECT_EQ(frames, 10u);
  EXPECT_THAT(faults(package(), frames), IsEmpty());
  EXPECT_EQ(frames, 14u);
}

TEST_F(RecordingFaultsTest, no_more_than_a_multiple_of_a_recording_is_written_however_long_it_is) {
  LiveRecorder recorder(short_segments());
  recorder.hello(real_hello());
  std::uint32_t given = 0;
  std::uint64_t written = 0;
  for (const std::uint32_t segments : {300u, 600u, 1'200u}) {
    const std::uint64_t before = bytes_written();
    give_small(recorder, given, segments - given);
    given = segments;
    written += bytes_written() - before;
    EXPECT_LT(written, 12 * bytes_of(package())) << "after " << segments << " segments";
  }
}

TEST_F(RecordingFaultsTest, a_long_recording_has_all_its_segments_at_every_moment) {
  LiveRecorder recorder(short_segments());
  recorder.hello(real_hello());
  const std::uint32_t first = give_until_journal(recorder, 1);
  bool had_journal = false, had_none = false;
  for (std::uint32_t i = first; i < first + 60; ++i) {
    give_small(recorder, i, 1);
    (fs::exists(journal()) ? had_journal : had_none) = true;
    const auto manifest = read_manifest(package());
    ASSERT_TRUE(manifest) << manifest.error().message;
    ASSERT_EQ(manifest->frame_count(), i);
    EXPECT_EQ(manifest->duration_us, i * kPeriod);
    EXPECT_TRUE(manifest->live);
  }
  EXPECT_TRUE(had_journal && had_none) << "the manifest was rewritten meanwhile";
  std::uint32_t frames = 0;
  EXPECT_THAT(faults(package(), frames), IsEmpty());
  recorder.end();
  EXPECT_FALSE(fs::exists(journal()));
  EXPECT_FALSE(read_manifest(package()).value().live);
  EXPECT_EQ(read_manifest(package()).value().frame_count(), first + 60);
}

TEST_F(RecordingFaultsTest, a_journal_that_outlived_its_manifest_adds_nothing) {
  LiveRecorder recorder(short_segments());
  recorder.hello(real_hello());
  const std::uint32_t given = give_until_journal(recorder, 1);
  const fs::path copy = copy_as_if_killed("old");
  recorder.end();
  const Manifest manifest = read_manifest(package()).value();
  fs::copy_file(copy / kJournalName, journal());
  EXPECT_EQ(read_manifest(package()).value().frame_count(), given);
  EXPECT_FALSE(read_manifest(package()).value().live);
  fs::copy_file(package() / kManifestName, copy / kManifestName,
                fs::copy_options::overwrite_existing);
}

TEST_F(RecordingFaultsTest, recordings_of_a_killed_program_are_completed_and_others_left_alone) {
  LiveRecorder recorder(short_segments());
  recorder.hello(real_hello());
  const std::uint32_t given = give_until_journal(recorder, 1);
  const fs::path copy = copy_as_if_killed("stage");
  complete_recordings(copy.parent_path(), {});
  complete_recordings(package().parent_path(), {});
  EXPECT_FALSE(fs::exists(copy / kJournalName));
  EXPECT_EQ(parse_manifest(read_text(copy / kManifestName)).value().frame_count(), given - 1);
  EXPECT_FALSE(read_manifest(copy).value().live);
  EXPECT_TRUE(fs::exists(journal())) << "it is still being recorded";
  give_small(recorder, given, 1);
  EXPECT_EQ(read_manifest(package()).value().frame_count(), given);
}

/// Sound from one time on until another, in packets of silence.
void give_sound(LiveSink& sink, std::uint64_t from_ms, std::uint64_t to_ms) {
  constexpr std::uint8_t kSilence[]{0xfc, 0xff, 0xfe};
  for (; from_ms < to_ms; from_ms += 20) {
    const auto bytes = std::make_shared<const Bytes>(write_live_sound(
        {static_cast<std::uint32_t>(from_ms / 20), kStart + 1000 * from_ms, 960, kSilence}));
    sink.sound(parse_live_sound(*bytes).value(), {LiveMessage::Kind::binary, bytes});
  }
}

TEST_F(RecordingFaultsTest, the_sound_of_a_killed_program_is_added_to_its_recording) {
  LiveRecorder recorder(options());
  recorder.hello(real_hello());
  // The first page is full after 255 packets.
  give_sound(recorder, 0, 6'000);
  give_frames(recorder, 0, 12);
  const fs::path silent = copy_as_if_killed("silent");
  EXPECT_FALSE(read_manifest(silent).value().audio);
  std::ofstream(silent / ".sound", std::ios::app) << "OggS and no more";
  complete_recordings(silent.parent_path(), {});
  std::uint32_t frames = 0;
  EXPECT_THAT(faults(silent, frames), IsEmpty());
  EXPECT_EQ(frames, 10u);
  const Manifest manifest = read_manifest(silent).value();
  EXPECT_FALSE(manifest.live);
  ASSERT_TRUE(manifest.audio);
  EXPECT_GE(manifest.audio->samples, 250u * 960);
  EXPECT_FALSE(fs::exists(silent / ".sound"));

  // The publisher has gone, and come back for a while.
  recorder.end();
  recorder.hello(real_hello());
  const fs::path longer = copy_as_if_killed("longer");
  complete_recordings(longer.parent_path(), {});
  EXPECT_EQ(read_manifest(longer)->audio->samples, 300u * 960) << "nothing is lost";
  give_sound(recorder, 6'000, 14'000);
  give_frames(recorder, 12, 8);
  const fs::path longest = copy_as_if_killed("longest");
  complete_recordings(longest.parent_path(), {});
  EXPECT_THAT(faults(longest, frames), IsEmpty());
  EXPECT_GE(read_manifest(longest)->audio->samples, 550u * 960);
  int files = 0;
  for (const auto& entry : fs::directory_iterator(longest))
    files += entry.path().extension() == ".opus";
  EXPECT_EQ(files, 1);
  EXPECT_TRUE(fs::exists(package() / ".sound")) << "it is still being recorded";

  fs::remove_all(silent);
  const fs::path empty = copy_as_if_killed("empty");
  fs::resize_file(empty / ".sound", 50);
  complete_recordings(empty.parent_path(), {});
  EXPECT_FALSE(fs::exists(empty / ".sound"));
  EXPECT_TRUE(read_manifest(empty)->audio) << "that of before stays";
}

TEST_F(RecordingFaultsTest, a_damaged_journal_gives_an_error_or_a_valid_manifest) {
  LiveRecorder recorder(short_segments());
  recorder.hello(real_hello());
  give_until_journal(recorder, 1'500);
  const fs::path copy = copy_as_if_killed("damaged");
  const std::string good = read_text(copy / kJournalName);
  const std::uint32_t whole = read_manifest(copy).value().frame_count();
  std::minstd_rand random(1);
  for (int i = 0; i < 300; ++i) {
    std::string damaged = good;
    for (int changes = 1 + i % 3; changes > 0; --changes) {
      damaged[random() % damaged.size()] = "0{}[]\",:\n\xff"[random() % 10];
    }
    if (i % 4 == 0) damaged.resize(random() % damaged.size());
    std::ofstream(copy / kJournalName, std::ios::binary) << damaged;
    const auto manifest = read_manifest(copy);
    if (manifest) {
      EXPECT_LE(manifest->frame_count(), whole);
    } else {
      EXPECT_THAT(manifest.error().message, HasSubstr(copy.string()));
    }
  }
}

}  // namespace
}  // namespace pointreel::recording_faults_test
