#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace pointreel {

struct LoadOptions {
  /// http://HOST:PORT/NAME: each viewer plays the package in real time and in a loop, each from
  /// another moment on, and requests all layers of a frame, with one range each, when the frame is
  /// due. ws://HOST:PORT/live/NAME: each viewer receives the live stream. HOST is a numeric
  /// address.
  std::string url;
  unsigned viewers = 200;
  double seconds = 10.0;  ///< the measured time, which follows the warm-up
  double warm_up = 1.0;   ///< seconds
  std::string token;      ///< bearer token, unless empty
};

struct LoadFigures {
  double seconds = 0.0;
  std::uint64_t frames = 0;      ///< that arrived completely
  std::uint64_t incomplete = 0;  ///< requested or begun, but not complete
  std::uint64_t missing = 0;     ///< live: frames of which a viewer received nothing
  std::uint64_t broken = 0;      ///< connections that ended
  std::uint64_t bytes = 0;
  double cpu_seconds = 0.0;  ///< of the generator
  /// For each complete frame, the milliseconds from when it was due (live: captured, by the clock
  /// of the publisher) until its last byte arrived, sorted.
  std::vector<float> delays_ms;

  /// The delay that the given share of the frames does not exceed. Frames that did not arrive
  /// completely count as later than all others.
  double delay_ms(double share) const;
  double bits_per_second() const { return 8.0 * static_cast<double>(bytes) / seconds; }
};

}  // namespace pointreel
