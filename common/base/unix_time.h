#pragma once

#include <chrono>
#include <cstdint>

namespace pointreel {

/// Microseconds since 1970 by this machine's clock, which may be set and so jump.
inline std::uint64_t unix_time_us() {
  return static_cast<std::uint64_t>(std::chrono::duration_cast<std::chrono::microseconds>(
                                        std::chrono::system_clock::now().time_since_epoch())
                                        .count());
}

}  // namespace pointreel
