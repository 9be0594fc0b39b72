#pragma once

#include <cstdint>
#include <optional>
#include <span>

namespace pointreel {

/// So many `frames` in so many `seconds`, in lowest terms and both at most 1,000,000: 30000 in
/// 1001.
struct FrameRate {
  std::uint64_t frames = 0, seconds = 1;
  bool operator==(const FrameRate&) const = default;
};

/// The rate at which frames begin at these times, which were rounded to microseconds: one of
/// television's if that fits, else the simplest. None if there is none, or fewer than two times.
std::optional<FrameRate> exact_rate(std::span<const std::uint64_t> times_us);

}  // namespace pointreel
