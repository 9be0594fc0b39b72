#include "client/sound/live_track.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include <opus/opus.h>

#include "client/source/live_source.h"

namespace pointreel {
namespace {

using std::chrono::milliseconds;

constexpr std::int64_t kSecond = 1'000'000, kRate = kAudioRate;
/// Samples that are kept.
constexpr std::int64_t kKept = 8 * kRate;
/// Times of packets that are closer than this to the end of the one before go on from there.
constexpr std::int64_t kClose = kRate / 50;
/// The longest gap that is filled with silence. After another, or a step back, all begins anew.
constexpr std::int64_t kLongest = 4 * kRate;
/// How far the delay may be off before it is set, and how long it stays then.
constexpr std::int64_t kMostDelayOff = 80'000;
constexpr milliseconds kStays{1500};
/// The share by which the need for delay falls with each packet.
constexpr double kForget = 0.002;
constexpr std::uint64_t kDuration = std::uint64_t{1} << 50;

}  // namespace

void LiveTrack::Decoder::operator()(OpusDecoder* decoder) const { opus_decoder_destroy(decoder); }

LiveTrack::LiveTrack()
    : decoder_(opus_decoder_create(kAudioRate, 2, nullptr)),
      decoded_(kMaxSoundSamples),
      ring_(static_cast<std::size_t>(kKept)) {}

LiveTrack::~LiveTrack() = default;

bool LiveTrack::begun() const {
  const std::lock_guard lock(mutex_);
  return origin_us_ != 0;
}

std::int64_t LiveTrack::delay_us() const {
  const std::lock_guard lock(mutex_);
  return delay_us_;
}

std::uint64_t LiveTrack::gaps() const {
  const std::lock_guard lock(mutex_);
  return gaps_;
}

void LiveTrack::restart(std::uint64_t capture_us) {
  // Some seconds before, so that positions with a delay are not negative.
  constexpr std::uint64_t kBefore = 60 * kSecond;
  origin_us_ = std::max<std::uint64_t>(capture_us, kBefore + 1) - kBefore;
  std::fill(ring_.begin(), ring_.end(), StereoSample{});
  end_ = static_cast<std::int64_t>(capture_us - origin_us_) * kRate / kSecond;
  needed_us_ = 0;
  number_.reset();
  clock_.reset();
}

void LiveTrack::add(const LiveSound& sound, std::uint64_t now_us) {
  const std::lock_guard lock(mutex_);
  if (decoder_ == nullptr) return;
  // Numbers begin anew with a new publisher.
  if (number_ && sound.number == *number_) return;
  const int samples = opus_decode_float(decoder_.get(), sound.packet.data(),
                                        static_cast<opus_int32>(sound.packet.size()),
                                        &decoded_.front().left, kMaxSoundSamples, 0);
  if (samples <= 0) return;
  for (StereoSample& sample : decoded_) {
    if (!std::isfinite(sample.left) || !std::isfinite(sample.right)) sample = {};
  }
  if (origin_us_ == 0 || sound.capture_us < origin_us_) restart(sound.capture_us);
  auto first = static_cast<std::int64_t>(sound.capture_us - origin_us_) / kSecond * kRate +
               static_cast<std::int64_t>(sound.capture_us - origin_us_) % kSecond * kRate / kSecond;
  if (first < end_ - kLongest || first > end_ + kLongest) {
    restart(sound.capture_us);
    first = end_;
  }
  if (std::abs(first - end_) < kClose) first = end_;
  place(first, {decoded_.data(), static_cast<std::size_t>(samples)});
  number_ = sound.number;
  const std::int64_t came = static_cast<std::int64_t>(now_us) -
                            static_cast<std::int64_t>(sound.capture_us) + kSoundLead.count();
  const bool known = clock_.has_value() || needed_us_ != 0;
  needed_us_ =
      known ? std::max(came,
                       needed_us_ - static_cast<std::int64_t>(
                                        kForget * static_cast<double>(std::abs(needed_us_ - came))))
            : came;
}

/// What is between the end and `first` becomes silence, and what lies before the end is left out.
void LiveTrack::place(std::int64_t first, std::span<const StereoSample> samples) {
  const auto at = [this](std::int64_t n) -> StereoSample& {
    return ring_[static_cast<std::size_t>(n % kKept)];
  };
  for (; end_ < first; ++end_) at(end_) = {};
  const std::int64_t skipped = end_ - first;
  for (auto i = skipped; i < std::ssize(samples); ++i)
    at(end_++) = samples[static_cast<std::size_t>(i)];
}

bool LiveTrack::copy(std::int64_t first, std::span<StereoSample> to) {
  const std::lock_guard lock(mutex_);
  bool all = true;
  for (std::size_t i = 0; i < to.size(); ++i) {
    const std::int64_t n = first + static_cast<std::int64_t>(i);
    const bool there = n >= 0 && n < end_ && n >= end_ - kKept;
    to[i] = there ? ring_[static_cast<std::size_t>(n % kKept)] : StereoSample{};
    all = all && there;
  }
  if (!all) ++gaps_;
  return all;
}

std::optional<Clock> LiveTrack::clock(Clock::TimePoint now, std::uint64_t now_us,
                                      std::optional<std::int64_t> picture_delay_us) {
  const std::lock_guard lock(mutex_);
  if (origin_us_ == 0) return std::nullopt;
  const std::int64_t wanted = std::max(needed_us_, picture_delay_us.value_or(needed_us_));
  const std::int64_t position =
      static_cast<std::int64_t>(now_us) - static_cast<std::int64_t>(origin_us_) - wanted;
  bool set = !clock_;
  if (clock_) {
    const std::int64_t off = static_cast<std::int64_t>(clock_->read(now).position_us) - position;
    set = std::abs(off) > kMostDelayOff && now - set_ > kStays;
  }
  if (set && position >= 0) {
    clock_ = Clock({{0}, kDuration}, false);
    clock_->seek(static_cast<std::uint64_t>(position), now);
    clock_->play(now);
    set_ = now;
    delay_us_ = wanted;
  }
  return clock_;
}

}  // namespace pointreel
