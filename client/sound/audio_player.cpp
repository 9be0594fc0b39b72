#include "client/sound/audio_player.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/base/try.h"

namespace pointreel {
namespace {

// Seconds that what the device says may be off paced time, in one answer, and in the mean of the
// last dozen. What is off farther is not its pace: it had a break, or did not know its delay at
// first. Sound then jumps, and time does not.
constexpr double kMostSecondsOff = 0.05, kMostMeanOff = 0.01;
constexpr double kNewest = 0.1;  ///< share of the newest answer in this mean

AudioPlayer::TimePoint::duration duration_of(double seconds) {
  return std::chrono::round<AudioPlayer::TimePoint::duration>(
      std::chrono::duration<double>(seconds));
}

double seconds_of(AudioPlayer::TimePoint::duration time) {
  return std::chrono::duration<double>(time).count();
}

}  // namespace

AudioPlayer::AudioPlayer(OpenDevice open, std::shared_ptr<PacedTime> time)
    : open_(std::move(open)), time_(std::move(time)) {}

void AudioPlayer::begin(const std::vector<std::shared_ptr<AudioSamples>>& sounds) {
  std::vector<std::unique_ptr<Sound>> begun;
  for (const std::shared_ptr<AudioSamples>& samples : sounds)
    begun.push_back(samples ? std::make_unique<Sound>(samples, AudioVoice(*samples), std::nullopt)
                            : nullptr);
  const std::lock_guard lock(mutex_);
  sounds_.swap(begun);
}

void AudioPlayer::follow(std::size_t sound, const Clock& clock) {
  const std::lock_guard lock(mutex_);
  if (sound < sounds_.size() && sounds_[sound]) sounds_[sound]->clock = clock;
}

void AudioPlayer::set_volume(double volume) {
  const std::lock_guard lock(mutex_);
  gain_ = static_cast<float>(std::pow(std::clamp(volume, 0.0, 1.0), 3.0));
}

AudioPlayer::Statistics AudioPlayer::statistics() const {
  const std::lock_guard lock(mutex_);
  Statistics statistics = statistics_;
  if (statistics.offsets > 0)
    statistics.mean_offset_ms = sum_of_offsets_ms_ / static_cast<double>(statistics.offsets);
  return statistics;
}

/// The paced time at which a sample is heard.
AudioPlayer::TimePoint AudioPlayer::time_of(std::uint64_t sample) const {
  return *first_ + std::chrono::nanoseconds(sample / kAudioRate * 1'000'000'000 +
                                            sample % kAudioRate * 1'000'000'000 / kAudioRate);
}

bool AudioPlayer::pump(TimePoint now) {
  Result<void> done;
  if (open_) {
    auto device = std::exchange(open_, {})();
    if (device) {
      device_ = *std::move(device);
    } else {
      done = tl::unexpected(device.error());
    }
  }
  const std::lock_guard lock(mutex_);
  if (done && device_) done = play(now);
  if (!done) {
    statistics_.error = done.error().message;
    device_.reset();
    time_->let_go(now);
  }
  return statistics_.plays = device_ != nullptr;
}

Result<void> AudioPlayer::play(TimePoint now) {
  const AudioDevice::State state = TRY(device_->state(now));
  pace(state, now);
  return fill(state.room, now);
}

/// Lets paced time follow what the device has played.
void AudioPlayer::pace(const AudioDevice::State& state, TimePoint now) {
  statistics_.delay_ms = 1e3 * state.delay / kAudioRate;
  statistics_.breaks += state.broken_off;
  const double heard = static_cast<double>(written_) - state.delay;
  const TimePoint paced = time_->at(now);
  if (!first_) first_ = paced - duration_of(heard / kAudioRate);
  const double off = seconds_of(*first_ + duration_of(heard / kAudioRate) - paced);
  mean_off_ += kNewest * (off - mean_off_);
  const bool far = std::abs(off) > kMostSecondsOff || std::abs(mean_off_) > kMostMeanOff;
  if (state.broken_off || far) {
    *first_ -= duration_of(off);
    mean_off_ = 0.0;
    handed_.clear();
    return;
  }
  time_->follow(paced + duration_of(mean_off_), now);
  measure(heard, now);
}

void AudioPlayer::measure(double heard, TimePoint now) {
  while (handed_.size() > 1 && static_cast<double>(handed_[1].first) <= heard) handed_.pop_front();
  const auto sound = std::find_if(sounds_.begin(), sounds_.end(),
                                  [](const auto& one) { return one && one->clock; });
  if (handed_.empty() || sound == sounds_.end()) return;
  const Handed& now_heard = handed_.front();
  const Clock& clock = *(*sound)->clock;
  const double into = heard - static_cast<double>(now_heard.first);
  // Only where all that is waiting goes on from what is heard, by the clock as it is now.
  const bool steady = std::all_of(handed_.begin(), handed_.end(),
                                  [](const Handed& one) { return one.position && one.steady; });
  if (!steady || into < 0.0 || into > 2.0 * AudioVoice::kHop || !clock.playing() || clock.held())
    return;
  const double is = (static_cast<double>(*now_heard.position) + AudioVoice::kHop +
                     (into - AudioVoice::kHop) * clock.speed()) /
                    kAudioRate;
  const double should = 1e-6 * static_cast<double>(clock.read(time_->at(now)).position_us);
  const double offset_ms = 1e3 * (is - should);
  // The clock may have jumped since.
  if (std::abs(offset_ms) > 1e3 * kMostSecondsOff) return;
  ++statistics_.offsets;
  sum_of_offsets_ms_ += offset_ms;
  if (std::abs(offset_ms) > std::abs(statistics_.worst_offset_ms))
    statistics_.worst_offset_ms = offset_ms;
}

Result<void> AudioPlayer::fill(std::size_t room, TimePoint now) {
  while (room > 0) {
    if (rest_.empty()) mix(now);
    const std::size_t size = std::min(room, rest_.size());
    TRY(device_->write(rest_.first(size)));
    rest_ = rest_.subspan(size);
    written_ += size;
    room -= size;
  }
  return {};
}

/// Makes the hop that the device is given next.
void AudioPlayer::mix(TimePoint now) {
  mixed_.fill({});
  Handed handed{written_, std::nullopt, false};
  const TimePoint begin = time_of(written_);
  for (const auto& sound : sounds_) {
    if (!sound || !sound->clock) continue;
    sound->voice.add_hop(*sound->clock, begin, mixed_);
    if (handed.position) continue;
    handed.position = sound->voice.position();
    handed.steady = sound->voice.steady();
  }
  for (std::size_t i = 0; i < AudioVoice::kHop; ++i) {
    const float share = static_cast<float>(i + 1) / static_cast<float>(AudioVoice::kHop);
    const float gain = gain_before_ + share * (gain_ - gain_before_);
    mixed_[i] = {std::clamp(gain * mixed_[i].left, -1.0f, 1.0f),
                 std::clamp(gain * mixed_[i].right, -1.0f, 1.0f)};
  }
  gain_before_ = gain_;
  if (handed.position && !statistics_.first_heard)
    statistics_.first_heard = now + (begin - time_->at(now));
  handed_.push_back(handed);
  rest_ = mixed_;
}

}  // namespace pointreel
