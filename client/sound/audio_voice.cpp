#include "client/sound/audio_voice.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numbers>
#include <vector>

namespace pointreel {
namespace {

constexpr auto kHop = AudioVoice::kHop;
constexpr std::int64_t kSignedHop = kHop;
constexpr std::chrono::milliseconds kHopTime{10};
static_assert(kHop * 100 == kAudioRate);

/// How far, at normal speed, a grain may be from its position without being moved there: positions
/// are known to a microsecond.
constexpr std::int64_t kLoose = kAudioRate / 2000;
/// Positions that differ more than this from what the speed says have jumped.
constexpr std::int64_t kJump = kAudioRate / 500;
/// How far ahead sound is fetched and decoded, in seconds of playing.
constexpr double kAhead = 1.5;

/// The rise of a fade, which adds up to 1 with its fall.
const std::array<float, kHop>& rise() {
  static const std::array<float, kHop> table = [] {
    std::array<float, kHop> all{};
    for (std::size_t i = 0; i < kHop; ++i) {
      const double s = std::sin(0.5 * std::numbers::pi * (static_cast<double>(i) + 0.5) / kHop);
      all[i] = static_cast<float>(s * s);
    }
    return all;
  }();
  return table;
}

std::int64_t sample_at(std::uint64_t time_us) {
  return static_cast<std::int64_t>((time_us * (kAudioRate / 1000) + 500) / 1000);
}

/// The position at a time; none while nothing is to be heard.
std::optional<std::int64_t> position_at(const Clock& clock, Clock::TimePoint time) {
  if (!clock.playing() || clock.held() || clock.direction() < 0) return std::nullopt;
  const Clock::Reading reading = clock.read(time);
  if (reading.ended) return std::nullopt;
  return sample_at(reading.position_us);
}

}  // namespace

void AudioVoice::add_hop(const Clock& clock, Clock::TimePoint begin,
                         std::span<StereoSample, AudioVoice::kHop> to) {
  want(clock, begin);
  // The middle of the grain is where the clock says.
  std::optional<std::int64_t> nominal = position_at(clock, begin + kHopTime);
  if (nominal) *nominal -= kSignedHop;
  const bool normal = clock.speed() == 1.0;
  steady_ = false;
  std::optional<std::int64_t> position = nominal;
  if (nominal && nominal_) {
    const std::int64_t expected =
        *nominal_ + std::llround(clock.speed() * static_cast<double>(kHop));
    steady_ = std::abs(*nominal - expected) <= kJump;
    const std::int64_t natural = *position_ + kSignedHop;
    if (steady_ && normal && std::abs(natural - *nominal) <= kLoose)
      position = natural;
    else if (steady_)
      position = best_fit(*nominal, natural, normal ? kLoose : kReach);
  }
  Grain grain{};
  if (position) samples_.copy(*position, grain);
  const auto& up = rise();
  for (std::size_t i = 0; i < kHop; ++i) {
    const float down = 1.0f - up[i];
    to[i].left += up[i] * grain[i].left + down * grain_[kHop + i].left;
    to[i].right += up[i] * grain[i].right + down * grain_[kHop + i].right;
  }
  grain_ = grain;
  position_ = position;
  nominal_ = nominal;
}

/// Where, near the nominal position, the sound is most like what follows naturally.
std::int64_t AudioVoice::best_fit(std::int64_t nominal, std::int64_t natural, std::int64_t reach) {
  const auto mono = [this](std::int64_t first, std::size_t size) {
    std::vector<StereoSample> both(size);
    std::vector<float> sum(size);
    samples_.copy(first, both);
    for (std::size_t i = 0; i < size; ++i) sum[i] = both[i].left + both[i].right;
    return sum;
  };
  const std::vector<float> model = mono(natural, kHop);
  const std::vector<float> around =
      mono(nominal - reach, static_cast<std::size_t>(2 * reach) + kHop);
  // Every fourth sample tells enough to find the neighbourhood.
  const auto likeness = [&](std::int64_t shift, std::size_t step) {
    const float* at = around.data() + reach + shift;
    float product = 0.0f, power = 1e-9f;
    for (std::size_t i = 0; i < kHop; i += step) {
      product += at[i] * model[i];
      power += at[i] * at[i];
    }
    return product / std::sqrt(power);
  };
  std::int64_t best = 0;
  float most = likeness(0, 4);
  for (std::int64_t shift = -reach; shift <= reach; shift += 4) {
    const float here = likeness(shift, 4);
    if (here > most) {
      most = here;
      best = shift;
    }
  }
  const std::int64_t from = std::max(-reach, best - 3), end = std::min(reach, best + 3);
  most = likeness(best, 1);
  for (std::int64_t shift = from; shift <= end; ++shift) {
    const float here = likeness(shift, 1);
    if (here > most) {
      most = here;
      best = shift;
    }
  }
  return nominal + best;
}

/// Asks for what is heard next, in the order in which it is heard, and for what is heard first if
/// playback goes on.
void AudioVoice::want(const Clock& clock, Clock::TimePoint begin) {
  const Clock::Reading now = clock.read(begin);
  const std::int64_t here = sample_at(now.position_us);
  std::vector<std::int64_t> wanted = {here, here - kReach, here + 3 * kSignedHop};
  const bool plays = position_at(clock, begin).has_value();
  const auto step = std::chrono::duration_cast<Clock::TimePoint::duration>(
      std::chrono::duration<double>(0.05 / std::abs(clock.speed())));
  const auto end = begin + std::chrono::duration_cast<Clock::TimePoint::duration>(
                               std::chrono::duration<double>(kAhead));
  std::int64_t passed = 0;
  for (auto time = begin + step; plays && time < end; time += step) {
    const std::optional<std::int64_t> next = position_at(clock, time);
    if (!next) break;
    wanted.push_back(*next);
  }
  // While it stands still, what follows.
  for (; !plays && passed < kSignedHop * 100; passed += kSignedHop * 5)
    wanted.push_back(here + passed);
  samples_.want(wanted);
}

}  // namespace pointreel
