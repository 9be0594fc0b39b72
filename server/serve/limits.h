#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>

#include "common/stream/live.h"

namespace pointreel {

/// What peers may take of the server.
struct Limits {
  std::size_t max_connections = 1024;  ///< for one more an idle one goes, or it gets 503
  /// Of these, of one address; of IPv6, of one network of 64 bits.
  std::size_t max_connections_per_address = 256;
  double requests_per_second = 0;  ///< of one address; 0: any number; beyond it 429 is answered
  /// From the first byte of a request (or the connection's begin) to the end of its head.
  std::chrono::milliseconds header_timeout{10'000};
  /// Between two requests of a connection; between signs of life of a live viewer; a
  /// publisher has five seconds, if that is less.
  std::chrono::milliseconds idle_timeout{60'000};
  /// Without the peer taking a single byte of a response.
  std::chrono::milliseconds stall_timeout{30'000};
  std::size_t max_message = kLiveHeaderSize + kMaxLiveLayer;  ///< bytes of a publisher's message
  double publish_rate = 0;                                    ///< bytes a second of one; 0: any
};

}  // namespace pointreel
