#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <map>
#include <numbers>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include "codec/audio/opus_reader.h"
#include "codec/package/manifest.h"
#include "common/file_system/lock_folder.h"
#include "common/process/ffmpeg.h"
#include "server/inspect/inspect.h"
#include "server/pack/audio.h"
#include "tests/packed_clouds.h"
#include "tests/tone.h"

namespace pointreel::audio_package_test {
namespace {

namespace fs = std::filesystem;
using testing::Contains;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using testing::StartsWith;

constexpr std::uint64_t kTenSeconds = 10'000'000;

double tone(std::uint32_t n, double rate) {
  return 0.5 * std::sin(2.0 * std::numbers::pi * 440.0 * n / rate);
}

/// Runs ffmpeg, and returns the file that it writes.
fs::path converted(const fs::path& from, const std::string& name) {
  const fs::path to = from.parent_path() / name;
  const std::string command = "ffmpeg -v quiet -y -i '" + from.string() + "' '" + to.string() + "'";
  EXPECT_EQ(std::system(command.c_str()), 0) << command;
  return to;
}

/// Five seconds of sound that ffmpeg finds something wrong with, though all of it is there.
fs::path damaged_flac(const fs::path& sound) {
  write_wav(sound, 44'100, 5 * 44'100, [](std::uint32_t n) { return tone(n, 44'100.0); });
  const fs::path file = converted(sound, "damaged.flac");
  std::string bytes = read_text(file);
  for (std::size_t i = bytes.size() / 2; i < bytes.size() / 2 + 500; ++i) bytes[i] = 'x';
  write_file(file, bytes);
  return file;
}

/// Inputs of 5 frames, which take 0.2 s, and a second of a tone.
class AudioPackage : public testing::Test {
 protected:
  void SetUp() override {
    if (!is_installed("ffmpeg")) GTEST_SKIP() << "ffmpeg is not installed";
    write_frames(folder() / "in", 5);
    write_wav(sound(), 44'100, 44'100, [](std::uint32_t n) { return tone(n, 44'100.0); });
  }

  Result<PackSummary> pack_with(const fs::path& audio) const {
    PackOptions options = pack_options(folder() / "in", reel());
    options.audio = audio;
    options.force = true;
    return pack(options);
  }
  void pack_silent() const { ASSERT_TRUE(pack(pack_options(folder() / "in", reel()))); }
  /// Gives a reel of five seconds sound. Between encoding it and changing the reel, something else
  /// happens: ffmpeg's warning is the occasion.
  Result<std::optional<AudioFile>> replace_audio_while(const std::function<void()>& happens) const {
    PackOptions options = pack_options(folder() / "in", reel());
    options.fps = 1.0;
    EXPECT_TRUE(pack(options));
    bool happened = false;
    auto result = replace_audio(reel(), damaged_flac(sound()), {}, [&](const std::string&) {
      happens();
      happened = true;
    });
    EXPECT_TRUE(happened);
    return result;
  }

  fs::path folder() const { return folder_.path(); }
  fs::path reel() const { return folder() / "reel"; }
  fs::path sound() const { return folder() / "tone.wav"; }
  Manifest manifest() const { return read_manifest(reel()).value(); }
  std::vector<Fault> faults() const { return verify(reel()).value().faults; }

 private:
  TemporaryFolder folder_;
};

TEST_F(AudioPackage, is_packed_with_sound_as_long_as_its_frames) {
  const auto summary = pack_with(sound());
  ASSERT_TRUE(summary) << summary.error().message;
  const Manifest packed = manifest();
  ASSERT_TRUE(packed.audio);
  EXPECT_EQ(packed.audio->samples, kAudioRate / 5);
  EXPECT_THAT(packed.audio->path, StartsWith("audio."));
  EXPECT_THAT(faults(), IsEmpty());

  const std::string text = read_text(reel() / packed.audio->path);
  const Bytes bytes(text.begin(), text.end());
  auto reader = OpusReader::open(bytes);
  ASSERT_TRUE(reader) << reader.error().message;
  std::vector<StereoSample> samples(kAudioRate);
  std::size_t size = 0;
  for (;;) {
    const auto read = reader->read(std::span(samples).subspan(size));
    ASSERT_TRUE(read);
    if (read->samples == 0) break;
    size += read->samples;
  }
  ASSERT_EQ(size, packed.audio->samples);
  // What is heard at a time is what the source has at that time, but for the loss of the coding.
  double error = 0.0, power = 0.0;
  for (std::size_t n = 480; n < size - 480; ++n) {
    const double right = tone(static_cast<std::uint32_t>(n), kAudioRate);
    error += std::pow(samples[n].left - right, 2.0);
    power += right * right;
  }
  EXPECT_LT(error, 0.01 * power);
}

TEST_F(AudioPackage, tells_how_much_of_the_source_was_cut_off) {
  const auto cut = pack_with(sound());
  ASSERT_TRUE(cut) << cut.error().message;
  ASSERT_TRUE(cut->audio);
  EXPECT_EQ(encoded_audio_text(*cut->audio), "0.2 s of 1 s (the rest was cut off)");
  for (const char* name : {"a.flac", "a.mp3", "a.ogg"}) {
    write_wav(sound(), 44'100, 5 * 44'100, [](std::uint32_t n) { return tone(n, 44'100.0); });
    const auto known = write_audio(converted(sound(), name), folder(), 500'000);
    ASSERT_TRUE(known) << known.error().message;
    EXPECT_TRUE(known->cut_off) << name;
    ASSERT_TRUE(known->source_us) << name;
    EXPECT_NEAR(static_cast<double>(*known->source_us), 5e6, 1e5) << name;
  }
  const auto unknown = write_audio(converted(sound(), "a.mka"), folder(), 500'000);
  ASSERT_TRUE(unknown) << unknown.error().message;
  EXPECT_EQ(encoded_audio_text(*unknown), "0.5 s (the rest was cut off)");
  const auto whole = write_audio(sound(), folder(), kTenSeconds);
  ASSERT_TRUE(whole) << whole.error().message;
  EXPECT_EQ(encoded_audio_text(*whole), "5 s");
}

TEST_F(AudioPackage, has_as_many_samples_for_ffmpeg) {
  ASSERT_TRUE(pack_with(sound()));
  const std::string command = "ffmpeg -v error -i '" + (reel() / manifest().audio->path).string() +
                              "' -f s16le -ac 1 - | wc -c";
  FILE* pipe = popen(command.c_str(), "r");
  unsigned bytes = 0;
  ASSERT_EQ(fscanf(pipe, "%u", &bytes), 1);
  pclose(pipe);
  EXPECT_EQ(bytes, 2 * kAudioRate / 5);
}

TEST_F(AudioPackage, gets_replaces_and_loses_sound_without_being_packed_again) {
  pack_silent();
  const auto before = contents(reel());
  const auto added = replace_audio(reel(), sound());
  ASSERT_TRUE(added) << added.error().message;
  EXPECT_THAT(faults(), IsEmpty());
  EXPECT_EQ(contents(reel()).size(), before.size() + 1);
  const std::string first = manifest().audio->path;

  write_wav(sound(), 48'000, 4'800, [](std::uint32_t n) { return 0.5 * tone(n, 48'000.0); });
  ASSERT_TRUE(replace_audio(reel(), sound()));
  EXPECT_EQ(manifest().audio->samples, 4'800u);
  EXPECT_NE(manifest().audio->path, first) << "caches keep files for good";
  EXPECT_FALSE(fs::exists(reel() / first));
  EXPECT_THAT(faults(), IsEmpty());

  ASSERT_TRUE(replace_audio(reel(), std::nullopt));
  EXPECT_EQ(contents(reel()), before);
}

TEST_F(AudioPackage, is_left_alone_if_it_was_replaced_while_its_sound_was_encoded) {
  std::map<std::string, std::string> replacement;
  const auto late = replace_audio_while([&] {
    ASSERT_TRUE(pack_with(sound()));
    replacement = contents(reel());
  });
  ASSERT_FALSE(late);
  EXPECT_THAT(late.error().message,
              StartsWith(reel().string() + ": another program has changed it meanwhile"));
  EXPECT_EQ(contents(reel()), replacement);
}

TEST_F(AudioPackage, keeps_the_sound_that_came_first_of_two_at_once) {
  std::map<std::string, std::string> first;
  EXPECT_FALSE(replace_audio_while([&] {
    write_wav(sound(), 48'000, 5 * 48'000, [](std::uint32_t) { return 0.0; });
    ASSERT_TRUE(replace_audio(reel(), sound()));
    first = contents(reel());
  }));
  EXPECT_EQ(contents(reel()), first);
}

TEST_F(AudioPackage, gets_no_sound_while_another_program_holds_its_lock) {
  pack_silent();
  const int lock = lock_folder(reel(), LOCK_NB);
  ASSERT_GE(lock, 0);
  const auto refused = replace_audio(reel(), sound());
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().message, HasSubstr("another program is writing to it"));
  ::close(lock);
  fs::create_symlink(reel(), folder() / "link");
  EXPECT_TRUE(replace_audio(folder() / "link", sound()));
}

TEST_F(AudioPackage, stays_as_it_is_if_the_source_has_no_sound) {
  pack_silent();
  const auto before = contents(reel());
  const auto refused = replace_audio(reel(), folder() / "in" / "frame_0.ply");
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().message, HasSubstr("frame_0.ply: cannot be read as sound"));
  const auto missing = replace_audio(reel(), folder() / "none.wav");
  ASSERT_FALSE(missing);
  EXPECT_THAT(missing.error().message, HasSubstr("none.wav: is not a file"));
  EXPECT_EQ(contents(reel()), before);
  EXPECT_FALSE(pack_with(folder() / "none.wav"));
  EXPECT_EQ(contents(reel()), before);
}

// ffmpeg ends well where a file does not.
TEST_F(AudioPackage, gets_no_sound_that_is_cut_off) {
  write_wav(sound(), 44'100, 5 * 44'100, [](std::uint32_t n) { return tone(n, 44'100.0); });
  for (const char* name : {"cut.wav", "cut.flac", "cut.mp3", "cut.mka", "cut.avi"}) {
    SCOPED_TRACE(name);
    const fs::path file = converted(sound(), name);
    const auto whole = write_audio(file, folder(), kTenSeconds);
    ASSERT_TRUE(whole) << whole.error().message;
    EXPECT_NEAR(static_cast<double>(whole->file.samples), 5.0 * kAudioRate, 0.1 * kAudioRate);
    fs::resize_file(file, fs::file_size(file) / 2);
    const auto cut = write_audio(file, folder(), kTenSeconds);
    ASSERT_FALSE(cut);
    EXPECT_THAT(cut.error().message, StartsWith(file.string() + ": ends after "));
    EXPECT_TRUE(write_audio(file, folder(), 1'000'000)) << "what is needed is there";
  }
}

TEST_F(AudioPackage, gets_no_sound_that_is_damaged_so_that_it_becomes_shorter) {
  write_wav(sound(), 44'100, 5 * 44'100, [](std::uint32_t n) { return tone(n, 44'100.0); });
  const fs::path file = converted(sound(), "damaged.mp3");
  std::string bytes = read_text(file);
  for (std::size_t i = bytes.size() / 3; i < bytes.size() / 3 * 2; ++i)
    bytes[i] = static_cast<char>(i * i % 251);
  write_file(file, bytes);
  const auto damaged = write_audio(file, folder(), kTenSeconds);
  ASSERT_FALSE(damaged);
  EXPECT_THAT(damaged.error().message, StartsWith(file.string()));
}

TEST_F(AudioPackage, says_what_ffmpeg_found_wrong_where_all_the_sound_is_there) {
  const fs::path file = damaged_flac(sound());
  std::vector<std::string> warnings;
  const auto made = write_audio(file, folder(), kTenSeconds, {},
                                [&](const std::string& line) { warnings.push_back(line); });
  ASSERT_TRUE(made) << made.error().message;
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_THAT(warnings[0], StartsWith(file.string() + ": "));
}

TEST_F(AudioPackage, gets_no_sound_from_playlists) {
  converted(sound(), "part.ts");
  const std::vector<std::pair<std::string, std::string>> playlists = {
      {"list.m3u8", "#EXTM3U\n#EXT-X-TARGETDURATION:2\n#EXTINF:1,\npart.ts\n#EXT-X-ENDLIST\n"},
      {"list.wav", "ffconcat version 1.0\nfile part.ts\n"}};
  for (const auto& [name, text] : playlists) {
    write_file(folder() / name, text);
    const auto refused = write_audio(folder() / name, folder(), kTenSeconds);
    ASSERT_FALSE(refused) << name;
    EXPECT_THAT(refused.error().message, HasSubstr("playlists are not read"));
  }
}

TEST_F(AudioPackage, is_unpacked_with_its_sound) {
  ASSERT_TRUE(pack_with(sound()));
  const UnpackOptions options{.input = reel(), .output = folder() / "out", .force = true};
  ASSERT_TRUE(unpack(options));
  EXPECT_EQ(read_text(folder() / "out" / "audio.opus"), read_text(reel() / manifest().audio->path));
  EXPECT_TRUE(unpack(options)) << "a folder of unpacked frames may have sound";
  PackOptions again = pack_options(folder() / "out", folder() / "again");
  EXPECT_THAT(pack(again)->warnings,
              Contains(HasSubstr("audio.opus: not packed; add it with --audio")));
  again.audio = folder() / "out" / "audio.opus";
  again.force = true;
  EXPECT_THAT(pack(again)->warnings, Not(Contains(HasSubstr("audio.opus"))));
}

TEST_F(AudioPackage, is_faulty_if_its_sound_is_a_pipe) {
  ASSERT_TRUE(pack_with(sound()));
  const fs::path audio = reel() / manifest().audio->path;
  fs::remove(audio);
  ASSERT_EQ(::mkfifo(audio.c_str(), 0600), 0);
  EXPECT_FALSE(faults().empty());
  EXPECT_FALSE(check_audio(PackageFiles(reel()), *manifest().audio));
  EXPECT_FALSE(unpack({.input = reel(), .output = folder() / "out"}));
}

TEST_F(AudioPackage, is_faulty_if_its_sound_is_damaged_or_is_not_as_long_as_it_says) {
  ASSERT_TRUE(pack_with(sound()));
  Manifest edited = manifest();
  edited.audio->samples += 1;
  write_file(reel() / "reel.json", write_manifest(edited));
  const auto longer = faults();
  ASSERT_EQ(longer.size(), 1u);
  EXPECT_EQ(longer[0].file, edited.audio->path);
  EXPECT_THAT(longer[0].what, HasSubstr("decodes to 9600 samples, the manifest says 9601"));

  std::string bytes = read_text(reel() / edited.audio->path);
  bytes[bytes.size() / 2] = static_cast<char>(bytes[bytes.size() / 2] ^ 0x55);
  write_file(reel() / edited.audio->path, bytes);
  EXPECT_THAT(faults().at(0).what, HasSubstr("checksum"));
  edited.audio->samples -= 1;
  edited.audio->checksum =
      checksum_of({reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()});
  write_file(reel() / "reel.json", write_manifest(edited));
  EXPECT_EQ(faults().size(), 1u) << "the checksums of Ogg's pages find it, too";
}

TEST(OpusReader, refuses_what_is_not_opus) {
  for (const std::string& text : {std::string(), std::string("OggS"), std::string(1000, 'x')}) {
    const Bytes bytes(text.begin(), text.end());
    const auto reader = OpusReader::open(bytes);
    ASSERT_FALSE(reader);
    EXPECT_FALSE(reader.error().message.empty());
  }
}

TEST(OpusReader, passes_on_why_bytes_cannot_be_read) {
  const auto reader = OpusReader::open(
      [](std::uint64_t, std::span<std::uint8_t>) -> Result<void> {
        return fail(ErrorCode::cancelled, "stopped");
      },
      1000);
  ASSERT_FALSE(reader);
  EXPECT_EQ(reader.error().code, ErrorCode::cancelled);
  EXPECT_EQ(reader.error().message, "stopped");
}

}  // namespace
}  // namespace pointreel::audio_package_test
