#include "client/sound/audio_player.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "client/sound/null_device.h"

namespace pointreel::audio_player_test {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;
using TimePoint = Clock::TimePoint;

constexpr std::uint64_t kDuration = 340'000'000;

/// Sound whose samples tell their number, so that what is heard tells its position.
class Numbers : public AudioSamples {
 public:
  bool copy(std::int64_t first, std::span<StereoSample> to) override {
    for (std::size_t i = 0; i < to.size(); ++i) {
      const std::int64_t n = first + static_cast<std::int64_t>(i);
      const float value = n >= 0 && n < kSamples ? std::ldexp(static_cast<float>(n + 1), -24) : 0;
      to[i] = {value, value};
    }
    return true;
  }
  void want(const std::vector<std::int64_t>& samples) override { wanted = samples; }

  /// Where the sound of this value is, in milliseconds; nothing for silence.
  static std::optional<double> position_ms(StereoSample sample) {
    if (sample.left == 0.0f) return std::nullopt;
    return (std::ldexp(sample.left, 24) - 1.0) * 1000.0 / kAudioRate;
  }

  std::vector<std::int64_t> wanted;

 private:
  static constexpr std::int64_t kSamples = kDuration / 1000 * (kAudioRate / 1000);
};

class Tone : public AudioSamples {
 public:
  bool copy(std::int64_t first, std::span<StereoSample> to) override {
    for (std::size_t i = 0; i < to.size(); ++i) {
      const double n = static_cast<double>(first) + static_cast<double>(i);
      const auto value =
          static_cast<float>(0.5 * std::sin(2.0 * std::numbers::pi * 440.0 * n / kAudioRate));
      to[i] = {value, value};
    }
    return true;
  }
  void want(const std::vector<std::int64_t>&) override {}
};

/// A card that remembers what it was given, and can fail.
class Card : public AudioDevice {
 public:
  Card(double pace, std::size_t latency) : device_(pace, latency) {}

  Result<State> state(TimePoint now) override {
    if (fails) return fail(ErrorCode::io, "unplugged");
    if (const auto state = device_.state(now)) last = *state;
    return last;
  }
  Result<void> write(std::span<const StereoSample> samples) override {
    given.insert(given.end(), samples.begin(), samples.end());
    return device_.write(samples);
  }
  /// What is heard at the last call of state(), at most a sample earlier.
  StereoSample heard() const {
    const double at = static_cast<double>(given_before_) - last.delay;
    return at < 0.0 ? StereoSample{} : given[static_cast<std::size_t>(at)];
  }
  void note() { given_before_ = given.size(); }

  bool fails = false;
  State last;
  std::vector<StereoSample> given;

 private:
  NullDevice device_;
  std::size_t given_before_ = 0;
};

/// A player, a reel's clock, and a card a thousandth faster than the machine, which tells its
/// delay.
class AudioPlayerTest : public testing::Test {
 protected:
  AudioPlayerTest() {
    const AudioPlayer::OpenDevice open = [this]() -> Result<std::unique_ptr<AudioDevice>> {
      auto card = std::make_unique<Card>(1.001, 960);
      card_ = card.get();
      return card;
    };
    player_ = std::make_unique<AudioPlayer>(open, time_);
    player_->pump(now_);
    player_->begin({numbers_});
  }

  TimePoint paced() const { return time_->at(now_); }

  /// Lets some time pass, a round of the player's thread after another, which are not quite even.
  void pass(milliseconds time) {
    const TimePoint end = now_ + time;
    while (now_ < end) {
      now_ += microseconds(5'000 + std::uniform_int_distribution(0, 6'000)(random_));
      player_->follow(0, clock_.without_frames());
      card_->note();
      player_->pump(now_);
    }
  }

  /// How far what is heard is ahead of the picture, in milliseconds.
  double offset_ms() {
    const auto heard = Numbers::position_ms(card_->heard());
    if (!heard) return 1e9;
    return *heard - 1e-3 * static_cast<double>(clock_.read(paced()).position_us);
  }
  bool silent() const { return card_->heard().left == 0.0f; }

  /// Looks again and again for some time.
  void expect_together(milliseconds time, const std::string& when) {
    for (const TimePoint end = now_ + time; now_ < end;) {
      pass(milliseconds(20));
      ASSERT_NEAR(offset_ms(), 0.0, 20.0) << when;
      worst_ms_ = std::max(worst_ms_, std::abs(offset_ms()));
    }
  }

  static Timeline timeline() {
    Timeline timeline;
    for (std::uint64_t us = 0; us < kDuration; us += 33'333) timeline.times_us.push_back(us);
    timeline.duration_us = kDuration;
    return timeline;
  }

  std::mt19937 random_{7};
  TimePoint now_{std::chrono::seconds(1000)};
  const std::shared_ptr<PacedTime> time_ = std::make_shared<PacedTime>();
  const std::shared_ptr<Numbers> numbers_ = std::make_shared<Numbers>();
  Clock clock_{timeline(), true};
  Card* card_ = nullptr;
  std::unique_ptr<AudioPlayer> player_;
  double worst_ms_ = 0.0;
  /// After this, what was handed to the card before is no longer heard.
  static constexpr milliseconds kSettled{150};
};

TEST_F(AudioPlayerTest, keeps_pictures_with_a_card_that_is_a_thousandth_too_fast) {
  clock_.play(paced());
  pass(kSettled);
  expect_together(std::chrono::seconds(330), "playing");
  EXPECT_LT(worst_ms_, 5.0) << "meanwhile the card plays 330 ms more than the machine's clock says";
  const auto statistics = player_->statistics();
  EXPECT_GT(statistics.offsets, 1000u);
  EXPECT_LT(std::abs(statistics.worst_offset_ms), 5.0);
  EXPECT_EQ(statistics.breaks, 0u);
}

TEST_F(AudioPlayerTest, gives_samples_as_they_are_at_normal_speed) {
  clock_.play(paced());
  pass(std::chrono::seconds(20));
  const auto& given = card_->given;
  const auto begin = std::find_if(given.begin(), given.end(),
                                  [](const auto& sample) { return sample.left > 0.0f; });
  const std::size_t first = static_cast<std::size_t>(begin - given.begin()) + kAudioRate / 50;
  ASSERT_LT(first + 800'000, given.size());
  for (std::size_t n = first; n < first + 800'000; ++n)
    ASSERT_NEAR(std::ldexp(given[n].left - given[first].left, 24), double(n - first), 0.51) << n;
}

TEST_F(AudioPlayerTest, is_together_with_the_picture_after_a_hundred_seeks) {
  clock_.play(paced());
  for (int i = 0; i < 100; ++i) {
    clock_.seek(std::uniform_int_distribution<std::uint64_t>(0, kDuration)(random_), paced());
    pass(kSettled);
    expect_together(milliseconds(100), "after seek " + std::to_string(i));
  }
}

TEST_F(AudioPlayerTest, waits_while_the_picture_waits) {
  clock_.play(paced());
  pass(kSettled);
  for (int i = 0; i < 20; ++i) {
    clock_.hold(paced());
    pass(kSettled);
    EXPECT_TRUE(silent());
    pass(milliseconds(std::uniform_int_distribution(0, 3'000)(random_)));
    EXPECT_TRUE(silent());
    clock_.release(paced());
    pass(kSettled);
    expect_together(milliseconds(300), "after stall " + std::to_string(i));
  }
}

TEST_F(AudioPlayerTest, follows_loops) {
  clock_.play(paced());
  clock_.set_loop_range(LoopRange{10'000'000, 10'700'000}, paced());
  clock_.seek(10'000'000, paced());
  pass(kSettled);
  int together = 0, passes = 0;
  double last = 0.0;
  for (int i = 0; i < 1000; ++i) {
    pass(milliseconds(10));
    const double position = 1e-6 * static_cast<double>(clock_.read(paced()).position_us);
    passes += position < last;
    last = position;
    // Where the end fades into the beginning, two positions are heard.
    together += std::abs(offset_ms()) <= 20.0;
  }
  EXPECT_GT(passes, 10);
  EXPECT_GT(together, 950);
  clock_.set_loop_range(std::nullopt, paced());
  clock_.seek(kDuration - 500'000, paced());
  pass(milliseconds(1'000));
  expect_together(milliseconds(200), "after the whole");
}

TEST_F(AudioPlayerTest, is_together_at_any_speed) {
  clock_.play(paced());
  for (const double speed : {0.1, 0.5, 0.9, 1.1, 1.5, 2.0, 4.0, 1.0}) {
    clock_.seek(1'000'000, paced());
    clock_.set_speed(speed, paced());
    pass(kSettled);
    expect_together(milliseconds(2'000), "at speed " + std::to_string(speed));
  }
}

TEST_F(AudioPlayerTest, keeps_the_pitch_at_another_speed) {
  player_->begin({std::make_shared<Tone>()});
  clock_.play(paced());
  for (const double speed : {0.6, 1.5, 2.0}) {
    clock_.set_speed(speed, paced());
    pass(std::chrono::seconds(3));
    const auto& given = card_->given;
    int rises = 0;
    double power = 0.0;
    for (std::size_t n = given.size() - kAudioRate; n < given.size(); ++n) {
      rises += given[n - 1].left < 0.0f && given[n].left >= 0.0f;
      power += given[n].left * given[n].left;
    }
    EXPECT_NEAR(rises, 440, 5) << speed;
    EXPECT_NEAR(power / kAudioRate, 0.125, 0.01) << speed << ": parts fit to one another";
  }
}

TEST_F(AudioPlayerTest, is_silent_while_nothing_plays_forward) {
  pass(kSettled);
  EXPECT_TRUE(silent());
  clock_.seek(30'000'000, paced());
  clock_.play(paced());
  pass(kSettled);
  EXPECT_FALSE(silent());
  clock_.set_speed(-1.0, paced());
  pass(kSettled);
  EXPECT_TRUE(silent()) << "backward";
  clock_.set_speed(1.0, paced());
  clock_.pause(paced());
  pass(kSettled);
  EXPECT_TRUE(silent()) << "paused";
  clock_.set_loop(false, paced());
  clock_.seek(kDuration - 1, paced());
  clock_.play(paced());
  pass(kSettled);
  EXPECT_TRUE(silent()) << "at the end";
}

TEST_F(AudioPlayerTest, is_together_again_when_the_card_had_nothing_to_play) {
  clock_.play(paced());
  pass(kSettled);
  for (int i = 0; i < 10; ++i) {
    const TimePoint before = paced();
    const milliseconds busy(std::uniform_int_distribution(60, 400)(random_));
    now_ += busy;
    player_->pump(now_);
    EXPECT_NEAR(std::chrono::duration<double>(paced() - before).count(),
                std::chrono::duration<double>(busy).count(), 0.02)
        << "pictures go on";
    pass(kSettled);
    expect_together(milliseconds(200), "after break " + std::to_string(i));
  }
  EXPECT_EQ(player_->statistics().breaks, 10u);
}

TEST_F(AudioPlayerTest, lets_pictures_go_on_without_the_card) {
  clock_.play(paced());
  pass(std::chrono::seconds(1));
  card_->fails = true;
  const TimePoint before = paced();
  EXPECT_FALSE(player_->pump(now_));
  now_ += std::chrono::seconds(1);
  EXPECT_EQ(paced() - before, std::chrono::seconds(1));
  EXPECT_FALSE(player_->statistics().plays);
  EXPECT_EQ(player_->statistics().error, "unplugged");
}

TEST_F(AudioPlayerTest, is_as_loud_as_asked_for) {
  player_->begin({std::make_shared<Tone>()});
  clock_.play(paced());
  const auto loudest = [&] {
    pass(kSettled);
    float most = 0.0f;
    for (std::size_t n = card_->given.size() - 2'400; n < card_->given.size(); ++n)
      most = std::max(most, std::abs(card_->given[n].left));
    return most;
  };
  EXPECT_NEAR(loudest(), 0.5f, 0.01f);
  player_->set_volume(0.5);
  EXPECT_NEAR(loudest(), 0.0625f, 0.001f);
  player_->set_volume(0.0);
  EXPECT_EQ(loudest(), 0.0f);
}

TEST_F(AudioPlayerTest, asks_for_what_comes_next) {
  clock_.set_loop_range(LoopRange{10'000'000, 11'000'000}, paced());
  clock_.seek(10'900'000, paced());
  pass(milliseconds(20));
  EXPECT_NEAR(double(numbers_->wanted.front()), 10.9 * kAudioRate, 1.0) << "before it plays";
  clock_.play(paced());
  pass(milliseconds(20));
  const auto& wanted = numbers_->wanted;
  EXPECT_TRUE(std::any_of(wanted.begin(), wanted.end(), [](std::int64_t sample) {
    return sample / kAudioRate == 10 && sample % kAudioRate < 4'800;
  })) << "the beginning of the loop";
}

}  // namespace
}  // namespace pointreel::audio_player_test
