#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace pointreel {

struct LoadOptions {
  /// http://HOST:PORT/NAME: each plays the package in time and in a loop, from a moment of its own
  /// on, asking for all layers of a frame, one range each, when the frame is due. HOST is an
  /// address in digits. ws://HOST:PORT/live/NAME: each takes what comes.
  std::string url;
  unsigned viewers = 200;
  double seconds = 10.0;  ///< that are measured, after
  double warm_up = 1.0;
  std::string token;  ///< bearer token, unless empty
};

struct LoadFigures {
  double seconds = 0.0;
  std::uint64_t frames = 0;      ///< that came whole
  std::uint64_t incomplete = 0;  ///< that did not, although they were asked for, or had begun
  std::uint64_t missing = 0;     ///< live: numbers that a viewer saw nothing of
  std::uint64_t broken = 0;      ///< connections that ended
  std::uint64_t bytes = 0;
  double cpu_seconds = 0.0;  ///< of the generator
  /// From when a whole frame was due (live: captured, by the publisher's clock) until its last byte
  /// came, in milliseconds, sorted.
  std::vector<float> delays_ms;

  /// Frames that did not come whole count as later than all others.
  double delay_ms(double share) const;
  double bits_per_second() const { return 8.0 * static_cast<double>(bytes) / seconds; }
};

}  // namespace pointreel
