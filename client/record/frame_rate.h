#pragma once

#include <cstdint>
#include <optional>
#include <span>

namespace pointreel {

/// A fraction in lowest terms, for example 30000 frames in 1001 seconds. Both parts are at most
/// 1,000,000.
struct FrameRate {
  std::uint64_t frames = 0, seconds = 1;
  bool operator==(const FrameRate&) const = default;
};

/// The rate at which frames begin at these times, which are rounded to microseconds. If several
/// rates fit, a rate of television is preferred, then the simplest fraction. Empty if no rate fits
/// or there are fewer than two times.
std::optional<FrameRate> exact_rate(std::span<const std::uint64_t> times_us);

}  // namespace pointreel
