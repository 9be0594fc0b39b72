#include "client/record/frame_rate.h"

namespace pointreel {
namespace {

constexpr std::uint64_t kMaxPart = 1'000'000;

bool less(const FrameRate& a, const FrameRate& b) {
  using Wide = unsigned __int128;
  return Wide{a.frames} * b.seconds < Wide{b.frames} * a.seconds;
}

/// The fraction with the smallest denominator from low to high, which are above 0. Each call takes
/// a step of the continued fraction that they share.
FrameRate simplest(const FrameRate& low, const FrameRate& high) {
  const std::uint64_t whole = low.frames / low.seconds;
  if (low.frames % low.seconds == 0) return {whole, 1};
  if (high.frames / high.seconds > whole) return {whole + 1, 1};
  const FrameRate rest = simplest({high.seconds, high.frames - whole * high.seconds},
                                  {low.seconds, low.frames - whole * low.seconds});
  return {whole * rest.frames + rest.seconds, rest.frames};
}

}  // namespace

std::optional<FrameRate> exact_rate(std::span<const std::uint64_t> times_us) {
  if (times_us.size() < 2) return std::nullopt;
  FrameRate low{0, 1}, high{~std::uint64_t{0}, 1};
  for (std::size_t i = 1; i < times_us.size(); ++i) {
    const std::uint64_t passed = times_us[i] - times_us[0];
    if (passed < 2) return std::nullopt;
    // Rounding moved each of the two times by at most half a microsecond.
    const FrameRate least{1'000'000 * i, passed + 1}, most{1'000'000 * i, passed - 1};
    if (less(low, least)) low = least;
    if (less(most, high)) high = most;
  }
  if (less(high, low)) return std::nullopt;
  for (const std::uint64_t frames : {24'000u, 30'000u, 60'000u, 120'000u}) {
    const FrameRate television{frames, 1001};
    if (!less(television, low) && !less(high, television)) return television;
  }
  const FrameRate rate = simplest(low, high);
  if (rate.frames > kMaxPart || rate.seconds > kMaxPart) return std::nullopt;
  return rate;
}

}  // namespace pointreel
