#pragma once

#include <chrono>
#include <cstdint>

namespace pointreel {

/// When the program started, by the machine's clock and by a steady one.
struct ProgramStart {
  std::chrono::steady_clock::time_point steady = std::chrono::steady_clock::now();
  std::chrono::system_clock::time_point of_day = std::chrono::system_clock::now();
};
inline const ProgramStart kProgramStart;

/// Microseconds since 1970. The machine's clock is read once, when the program starts; from then on
/// a steady clock counts. Times of one program therefore never jump when the clock is set, and
/// their differences are true. Times of two programs agree as well as the clocks did when each of
/// them started.
inline std::uint64_t unix_time_us() {
  const auto passed = std::chrono::steady_clock::now() - kProgramStart.steady;
  const auto now = kProgramStart.of_day.time_since_epoch() + passed;
  return static_cast<std::uint64_t>(
      std::chrono::duration_cast<std::chrono::microseconds>(now).count());
}

}  // namespace pointreel
