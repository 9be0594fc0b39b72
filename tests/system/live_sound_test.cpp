// Sound of live streams, from its messages to what is heard.

#include "codec/live/live_sound.h"

#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <opus/opus.h>

#include "client/sound/live_track.h"
#include "codec/audio/opus_reader.h"
#include "codec/live/live_queue.h"
#include "server/relay/left_sound.h"
#include "server/relay/live_sound_file.h"
#include "server/relay/relay.h"
#include "tests/live_frames.h"
#include "tests/temporary_folder.h"

namespace pointreel::live_sound_test {
namespace {

using std::chrono::milliseconds;
using testing::HasSubstr;

constexpr std::uint16_t kSamples = 960;  // 20 ms
constexpr std::uint64_t kStart = 1'700'000'000'000'000;

/// A tone of 480 Hz, in packets.
class Tone {
 public:
  Tone() : encoder_(opus_encoder_create(48000, 2, OPUS_APPLICATION_AUDIO, nullptr)) {}
  ~Tone() { opus_encoder_destroy(encoder_); }
  Bytes packet() {
    std::vector<float> pcm;
    for (int i = 0; i < kSamples; ++i, ++at_) {
      const auto value = static_cast<float>(0.5 * std::sin(2.0 * 3.14159265358979 * at_ / 100.0));
      pcm.insert(pcm.end(), {value, value});
    }
    Bytes bytes(4000);
    const int size = opus_encode_float(encoder_, pcm.data(), kSamples, bytes.data(), 4000);
    EXPECT_GT(size, 0);
    bytes.resize(static_cast<std::size_t>(size));
    return bytes;
  }

 private:
  OpusEncoder* encoder_;
  int at_ = 0;
};

LiveMessage sound_message(std::uint32_t number, const Bytes& packet = {1, 2, 3}) {
  const Bytes bytes =
      write_live_sound({number, kStart + 20'000 * std::uint64_t{number}, kSamples, packet});
  return {LiveMessage::Kind::binary, std::make_shared<const Bytes>(bytes)};
}

TEST(LiveSound, messages_are_read_as_they_were_written) {
  const Bytes packet{9, 8, 7};
  const Bytes bytes = write_live_sound({5, kStart, kSamples, packet});
  EXPECT_TRUE(is_live_sound(bytes));
  EXPECT_FALSE(is_live_sound(*layer_message(0, 0).bytes));
  const auto read = parse_live_sound(bytes);
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(read->number, 5u);
  EXPECT_EQ(read->capture_us, kStart);
  EXPECT_EQ(read->samples, kSamples);
  EXPECT_EQ(Bytes(read->packet.begin(), read->packet.end()), packet);
}

TEST(LiveSound, each_lie_is_an_error) {
  const Bytes packet{1};
  const Bytes good = write_live_sound({0, 1, kSamples, packet});
  for (std::size_t size = 0; size < good.size(); ++size)
    EXPECT_FALSE(parse_live_sound(ByteView(good).first(size))) << size;
  for (std::size_t at = 0; at < kSoundHeaderSize; ++at) {
    Bytes bad = good;
    bad[at] ^= 1;
    EXPECT_FALSE(parse_live_sound(bad)) << at;
  }
  const auto error_of = [](const LiveSound& sound) {
    return parse_live_sound(write_live_sound(sound)).error().message;
  };
  EXPECT_THAT(error_of({0, ~std::uint64_t{0}, kSamples, packet}), HasSubstr("out of range"));
  EXPECT_THAT(error_of({0, 1, 0, packet}), HasSubstr("has 0 samples"));
  EXPECT_THAT(error_of({0, 1, kMaxSoundSamples + 1, packet}), HasSubstr("has 5761 samples"));
  EXPECT_THAT(error_of({0, 1, kSamples, Bytes(kMaxSoundPacket + 1)}), HasSubstr("more than 4096"));
}

TEST(LiveSound, a_file_has_the_packets_of_its_messages) {
  std::string file;
  for (const std::uint32_t number : {7u, 8u}) append_live_sound(file, *sound_message(number).bytes);
  const Bytes bytes(file.begin(), file.end());
  const auto sounds = parse_live_sound_file(bytes);
  ASSERT_TRUE(sounds);
  ASSERT_EQ(sounds->size(), 2u);
  EXPECT_EQ((*sounds)[1].number, 8u);
  EXPECT_EQ(Bytes((*sounds)[1].packet.begin(), (*sounds)[1].packet.end()), Bytes({1, 2, 3}));
  EXPECT_TRUE(parse_live_sound_file({})->empty());
  const std::size_t message = bytes.size() / 2;
  for (std::size_t size = 1; size < bytes.size(); ++size)
    EXPECT_EQ(parse_live_sound_file(ByteView(bytes).first(size)).has_value(), size == message);
}

TEST(LiveSound, goes_before_layers_and_waits_no_longer_than_a_second) {
  LiveQueue queue;
  queue.push(0, 0, 1, layer_message(0, 0, 1));
  for (std::uint32_t i = 0; i < 60; ++i) queue.sound(sound_message(i));
  for (std::uint32_t i = 10; i < 60; ++i)
    EXPECT_EQ(parse_live_sound(*queue.next()->bytes).value().number, i);
  EXPECT_EQ(brief(*queue.next()), "0.0");
  EXPECT_TRUE(queue.empty());
}

TEST(LiveSound, is_relayed_once_to_those_who_ask_for_it) {
  Relay relay;
  const auto publication = relay.publish("stage").value();
  EXPECT_FALSE(publication->message(sound_message(0)));  // before the hello
  ASSERT_TRUE(publication->message(publisher_message()));
  const auto silent = relay.join("stage", [] {}).value();
  int woken = 0;
  const auto viewer = relay.join("stage", [&] { ++woken; }, true).value();
  while (silent->next()) {
  }
  while (viewer->next()) {
  }
  for (const std::uint32_t number : {3u, 3u, 2u, 4u})
    ASSERT_TRUE(publication->message(sound_message(number)));
  EXPECT_EQ(woken, 1);
  EXPECT_EQ(parse_live_sound(*viewer->next()->bytes).value().number, 3u);
  EXPECT_EQ(parse_live_sound(*viewer->next()->bytes).value().number, 4u);
  EXPECT_FALSE(viewer->next());
  EXPECT_FALSE(silent->next());
  // Damaged ones end the publisher's connection, as damaged layers do.
  EXPECT_FALSE(publication->message(
      {LiveMessage::Kind::binary, std::make_shared<const Bytes>(Bytes{'P', 'R', 'S', '1'})}));
}

/// The strength of the sound around a position.
double strength(LiveTrack& track, std::uint64_t position_us) {
  std::vector<StereoSample> samples(480);
  track.copy(static_cast<std::int64_t>(position_us * 48 / 1000), samples);
  double sum = 0.0;
  for (const StereoSample& sample : samples) sum += std::abs(sample.left);
  return sum / 480.0;
}

TEST(LiveSound, is_heard_with_the_delay_of_the_picture_or_when_it_has_come) {
  const Clock::TimePoint now{milliseconds(1'000'000)};
  for (const std::int64_t picture : {0, 400'000}) {
    LiveTrack track;
    EXPECT_FALSE(track.clock(now, kStart, std::nullopt));
    Tone tone;
    for (std::uint32_t i = 0; i < 50; ++i) {
      const std::uint64_t capture = kStart + 20'000 * i;
      track.add({i, capture, kSamples, tone.packet()}, capture + 30'000);
    }
    const std::uint64_t end = kStart + 1'000'000;
    const auto clock = track.clock(now, end, picture);
    ASSERT_TRUE(clock);
    EXPECT_TRUE(clock->playing());
    EXPECT_NEAR(static_cast<double>(track.delay_us()), picture == 0 ? 140'000.0 : 400'000.0,
                10'000);
    const std::uint64_t position = clock->read(now).position_us;
    EXPECT_GT(strength(track, position), 0.2);
    // Behind what has come, and before it, is silence.
    EXPECT_EQ(strength(track, position + 1'000'000), 0.0);
    EXPECT_EQ(strength(track, position - 1'500'000), 0.0);
    // Small changes are left alone, and larger ones are followed after a while.
    (void)track.clock(now + milliseconds(2000), end + 2'000'000, picture + 50'000);
    EXPECT_LT(track.delay_us(), picture + 145'000);
    (void)track.clock(now + milliseconds(3000), end + 3'000'000, picture + 600'000);
    EXPECT_EQ(track.delay_us(), picture + 600'000);
  }
}

TEST(LiveSound, lost_packets_are_silence_and_a_jump_begins_anew) {
  LiveTrack track;
  Tone tone;
  const auto add = [&](std::uint32_t number, std::uint64_t capture) {
    track.add({number, capture, kSamples, tone.packet()}, capture + 30'000);
  };
  for (std::uint32_t i = 0; i < 20; ++i) add(i, kStart + 20'000 * i);
  for (std::uint32_t i = 30; i < 50; ++i) add(i, kStart + 20'000 * i);
  const Clock::TimePoint now{milliseconds(1'000'000)};
  const auto position = track.clock(now, kStart + 1'000'000, 0)->read(now).position_us +
                        static_cast<std::uint64_t>(track.delay_us()) - 1'000'000;  // of kStart
  EXPECT_GT(strength(track, position + 300'000), 0.2);
  EXPECT_EQ(strength(track, position + 500'000), 0.0);
  EXPECT_GT(strength(track, position + 800'000), 0.2);
  // Another publisher, whose clock is a day behind.
  constexpr std::uint64_t kDay = 86'400'000'000;
  for (std::uint32_t i = 0; i < 20; ++i) add(i, kStart - kDay + 20'000 * i);
  const auto clock = track.clock(now, kStart - kDay + 400'000, 0);
  ASSERT_TRUE(clock);
  EXPECT_GT(strength(track, clock->read(now).position_us), 0.2);
}

TEST(LiveSound, packets_that_are_no_opus_are_left_out) {
  LiveTrack track;
  for (std::uint32_t i = 0; i < 100; ++i) {
    Bytes garbage(1 + i * 7 % 90, static_cast<std::uint8_t>(37 * i));
    track.add({i, kStart + 20'000 * i, kSamples, garbage}, kStart);
  }
  std::vector<StereoSample> samples(960);
  track.copy(0, samples);
  for (const StereoSample& sample : samples) EXPECT_TRUE(std::isfinite(sample.left));
}

TEST(LiveSound, is_recorded_with_silence_where_packets_are_missing) {
  const TemporaryFolder folder;
  LiveSoundFile recorded(folder / "sound", kStart);
  Tone tone;
  const auto add = [&](std::uint64_t capture) {
    const Bytes packet = tone.packet();
    recorded.add({0, capture, kSamples, packet});
  };
  add(kStart - 20'000);  // before the recording
  for (std::uint64_t i = 10; i < 30; ++i) add(kStart + 20'000 * i);
  for (std::uint64_t i = 60; i < 100; ++i) add(kStart + 20'000 * i);
  add(kStart + 20'000 * 50);                                  // late
  add(kStart + 86'400'000'000);                               // a clock that jumped
  recorded.add({0, kStart + 2'000'000, 480, tone.packet()});  // says another length
  EXPECT_EQ(recorded.samples(), 100u * kSamples);
  const Bytes bytes = recorded.bytes().value();
  auto reader = OpusReader::open(bytes);
  ASSERT_TRUE(reader) << reader.error().message;
  EXPECT_EQ(reader->samples(), 100u * kSamples);
  const auto strength_at = [&](std::uint64_t packet) {
    std::vector<StereoSample> samples(kSamples);
    EXPECT_TRUE(read_exactly(*reader, packet * kSamples, samples));
    double sum = 0.0;
    for (const StereoSample& sample : samples) sum += std::abs(sample.left);
    return sum / kSamples;
  };
  EXPECT_LT(strength_at(5), 0.001);
  EXPECT_GT(strength_at(20), 0.2);
  EXPECT_LT(strength_at(45), 0.001);
  EXPECT_GT(strength_at(80), 0.2);
  // More may follow.
  add(kStart + 2'000'000);
  const Bytes longer = recorded.bytes().value();
  EXPECT_EQ(OpusReader::open(longer)->samples(), 101u * kSamples);
}

TEST(LiveSound, of_a_recording_that_was_cut_anywhere_all_whole_pages_are_found) {
  const TemporaryFolder folder;
  LiveSoundFile recorded(folder / "sound", kStart);
  Tone tone;
  for (std::uint64_t i = 0; i < 150; ++i) {
    const Bytes packet = tone.packet();
    recorded.add({0, kStart + 20'000 * i, kSamples, packet});
  }
  const Bytes whole = recorded.bytes().value();
  const LeftSound all = find_left_sound(whole);
  EXPECT_EQ(all.bytes, whole.size());
  EXPECT_EQ(all.samples, 150u * kSamples);
  // A page has about 4 KiB.
  EXPECT_GT(find_left_sound(ByteView(whole).first(whole.size() / 2)).samples, 50u * kSamples);
  LeftSound before;
  for (std::size_t size = 0; size <= whole.size(); size += 97) {
    Bytes cut(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size));
    cut.resize(size + size % 300);  // as file systems do where a machine lost its power
    const LeftSound left = find_left_sound(cut);
    ASSERT_LE(left.bytes, size);
    ASSERT_GE(left.samples, before.samples);
    before = left;
    if (left.samples == 0) continue;
    const auto reader = OpusReader::open(ByteView(cut).first(left.bytes));
    ASSERT_TRUE(reader) << size << ": " << reader.error().message;
    ASSERT_EQ(reader->samples(), left.samples);
  }
  Bytes damaged = whole;
  damaged[whole.size() / 2] ^= 1;
  EXPECT_LE(find_left_sound(damaged).bytes, whole.size() / 2);
}

}  // namespace
}  // namespace pointreel::live_sound_test
