#include "client/sound/audio_track.h"

#include <atomic>
#include <cmath>
#include <filesystem>
#include <numbers>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "client/sound/audio_passes.h"
#include "common/process/ffmpeg.h"
#include "server/pack/audio.h"
#include "tests/packed_reel.h"
#include "tests/temporary_folder.h"
#include "tests/tone.h"
#include "tests/wait.h"

namespace pointreel::audio_track_test {
namespace {

/// A minute of a tone that becomes louder, so that each time sounds different.
class AudioTrackTest : public testing::Test {
 protected:
  static constexpr std::int64_t kLength = 60 * kAudioRate;

  static double wave(std::int64_t n) {
    const double loud = 0.1 + 0.8 * static_cast<double>(n) / static_cast<double>(kLength);
    return loud * std::sin(2.0 * std::numbers::pi * 300.0 * static_cast<double>(n) / kAudioRate);
  }

  void SetUp() override {
    if (!is_installed("ffmpeg")) GTEST_SKIP() << "ffmpeg is not installed";
    write_wav(folder_ / "a.wav", kAudioRate, kLength, [](std::uint32_t n) { return wave(n); });
    const auto written = write_audio(folder_ / "a.wav", folder_.path(), 60'000'000);
    ASSERT_TRUE(written) << written.error().message;
    file_ = written->file;
    const std::string text = read_text(folder_ / file_.path);
    bytes_ = Bytes(text.begin(), text.end());
  }

  Result<Bytes> fetch(std::uint64_t offset, std::uint64_t size) {
    fetched_ += size;
    EXPECT_LE(offset + size, bytes_.size());
    const auto begin = bytes_.begin() + static_cast<std::ptrdiff_t>(offset);
    return Bytes(begin, begin + static_cast<std::ptrdiff_t>(size));
  }

  std::unique_ptr<AudioTrack> track() {
    return std::make_unique<AudioTrack>(
        file_,
        [this](std::uint64_t offset, std::uint64_t size, const std::stop_token&) {
          return fetch(offset, size);
        },
        [this](const Error& error) {
          error_ = error.message;
          failed_ = true;
        });
  }

  /// How much of the sound from `first` on is not as it should be, by its power.
  static double error_of(AudioTrack& track, std::int64_t first) {
    std::vector<StereoSample> samples(2'000);
    track.want({first, first + 2'000});
    EXPECT_TRUE(wait_until([&] { return track.copy(first, samples); })) << first;
    double error = 0.0, power = 0.0;
    for (std::size_t i = 0; i < samples.size(); ++i) {
      const double right = wave(first + static_cast<std::int64_t>(i));
      error += std::pow(samples[i].left - right, 2.0);
      power += right * right;
    }
    return error / power;
  }

  TemporaryFolder folder_;
  AudioFile file_;
  Bytes bytes_;
  std::atomic<std::uint64_t> fetched_ = 0;
  std::atomic<bool> failed_ = false;
  std::string error_;
};

TEST_F(AudioTrackTest, has_each_time_where_it_belongs) {
  const auto sound = track();
  for (const std::int64_t first : {0, 4'799, 1'000'000, 2'500'017, 100'000, 104'900, 2'870'000})
    EXPECT_LT(error_of(*sound, first), 0.02) << first;
  std::vector<StereoSample> samples(100);
  EXPECT_TRUE(sound->copy(-100, samples)) << "silent before the beginning";
  EXPECT_TRUE(sound->copy(kLength, samples)) << "silent after the end";
  EXPECT_EQ(samples[50].left, 0.0f);
}

TEST_F(AudioTrackTest, fetches_little_more_than_it_plays) {
  const auto sound = track();
  error_of(*sound, 30 * kAudioRate);
  EXPECT_LT(fetched_, bytes_.size() / 4);
}

TEST_F(AudioTrackTest, is_recorded_pass_after_pass_to_the_sample) {
  // A pass takes 48,000.48 samples.
  constexpr std::uint64_t kPassUs = 1'000'010;
  auto passes = AudioPasses::open(
      file_,
      [this](std::uint64_t offset, std::uint64_t size, const std::stop_token&) {
        return fetch(offset, size);
      },
      kPassUs);
  ASSERT_TRUE(passes) << passes.error().message;
  std::vector<StereoSample> samples(5 * kAudioRate);
  ASSERT_TRUE(passes->read(0, std::span(samples).first(1'000)));
  ASSERT_TRUE(passes->read(1'000, std::span(samples).subspan(1'000)));
  double error = 0.0, power = 0.0;
  for (std::size_t n = 0; n < samples.size(); ++n) {
    const std::size_t pass = static_cast<std::size_t>(static_cast<double>(n) / 48'000.48);
    const auto begin = static_cast<std::size_t>(std::ceil(static_cast<double>(pass) * 48'000.48));
    const double right = wave(static_cast<std::int64_t>(n - begin));
    error += std::pow(samples[n].left - right, 2.0);
    power += right * right;
  }
  EXPECT_LT(error, 0.02 * power);

  // After the sound of a reel that lasts longer there is silence.
  passes = AudioPasses::open(
      file_,
      [this](std::uint64_t offset, std::uint64_t size, const std::stop_token&) {
        return fetch(offset, size);
      },
      70'000'000);
  ASSERT_TRUE(passes->read(kLength + 5, std::span(samples).first(100)));
  EXPECT_EQ(samples[50].left, 0.0f);
}

TEST_F(AudioTrackTest, says_why_it_cannot_be_decoded) {
  bytes_.assign(bytes_.size(), 7);
  const auto sound = track();
  ASSERT_TRUE(wait_until([&] { return failed_.load(); }));
  EXPECT_EQ(error_, "is not Opus in Ogg");
  std::vector<StereoSample> samples(100);
  sound->want({0});
  EXPECT_FALSE(sound->copy(0, samples));
}

TEST_F(AudioTrackTest, stays_silent_where_the_file_is_damaged) {
  for (std::size_t i = bytes_.size() / 2; i < bytes_.size() / 2 + 100'000; ++i) bytes_[i] ^= 0x5a;
  const auto sound = track();
  EXPECT_LT(error_of(*sound, 5 * kAudioRate), 0.02);
  EXPECT_LT(error_of(*sound, 55 * kAudioRate), 0.02);
  std::vector<StereoSample> samples(100);
  sound->want({33 * kAudioRate});
  ASSERT_TRUE(wait_until([&] { return sound->copy(33 * kAudioRate, samples); }));
  EXPECT_EQ(samples[50].left, 0.0f);
  EXPECT_LT(error_of(*sound, 20 * kAudioRate), 0.02);
}

TEST_F(AudioTrackTest, keeps_a_bounded_number_of_blocks) {
  const auto sound = track();
  std::vector<std::int64_t> all;
  for (std::int64_t at = 0; at < kLength; at += AudioTrack::kBlock) all.push_back(at);
  sound->want(all);
  std::vector<StereoSample> samples(AudioTrack::kMostBlocks * AudioTrack::kBlock);
  ASSERT_TRUE(wait_until([&] { return sound->copy(0, samples); }));
  EXPECT_LT(error_of(*sound, 50 * kAudioRate), 0.02);
  EXPECT_FALSE(sound->copy(0, samples)) << "something else has taken their place";
}

}  // namespace
}  // namespace pointreel::audio_track_test
