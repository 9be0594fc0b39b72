#pragma once

#include <cstdint>

#include "pointreel/package.h"

namespace pointreel {

/// The number of the first sample that is not before a time, which is at most 2^53: as many samples
/// begin before the time.
constexpr std::uint64_t first_sample_from(std::uint64_t time_us) {
  constexpr std::uint64_t kSecond = 1'000'000;
  return time_us / kSecond * kAudioRate + (time_us % kSecond * kAudioRate + kSecond - 1) / kSecond;
}

}  // namespace pointreel
