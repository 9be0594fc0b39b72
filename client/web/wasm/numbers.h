#pragma once

#include <chrono>
#include <cstdint>

/// What numbers of JavaScript stand for.
namespace pointreel {

inline double address(const void* of) {
  return static_cast<double>(reinterpret_cast<std::uintptr_t>(of));
}

/// Of a time in microseconds.
inline std::chrono::steady_clock::time_point time_of(double us) {
  using Time = std::chrono::steady_clock::time_point;
  return Time(
      std::chrono::duration_cast<Time::duration>(std::chrono::duration<double, std::micro>(us)));
}

}  // namespace pointreel
