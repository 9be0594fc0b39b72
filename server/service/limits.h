#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>

#include "codec/live/live.h"

namespace pointreel {

/// How much of the server peers may use.
struct Limits {
  std::size_t max_connections = 1024;  ///< a further one replaces an idle one, or gets 503
  /// Of these, from one address, or from one IPv6 network of 64 bits.
  std::size_t max_connections_per_address = 256;
  double requests_per_second = 0;  ///< from one address; further ones get 429; 0: unlimited
  /// From the first byte of a request, or the start of the connection, to the end of its head; and
  /// from the start of a publisher's session to its hello.
  std::chrono::milliseconds header_timeout{10'000};
  /// Between two requests on a connection, and between signs of life of a live viewer. A publisher
  /// must give a sign of life within five seconds, if that is less.
  std::chrono::milliseconds idle_timeout{60'000};
  /// How long a peer may accept no byte of a response.
  std::chrono::milliseconds stall_timeout{30'000};
  std::size_t max_message = kLiveHeaderSize + kMaxLiveLayer;  ///< bytes of a publisher's message
  double publish_rate = 0;  ///< bytes per second from a publisher; 0: unlimited
  /// Bytes of text per second from a publisher. Every viewer gets them, and a publisher needs them
  /// only when something about its stream changes.
  double publish_text_rate = 256.0 * 1024.0;
  /// Bytes per second, on average, at which a publisher's message must come once it has begun; 0:
  /// none. See MessagePace.
  double least_rate = 4096;
  /// Publishers at a time that have not said hello, in all and from one address. They hold a
  /// connection, but neither a stream nor its name.
  std::size_t max_hellos = 64, max_hellos_per_address = 16;
  /// Bytes of publishers' messages that are not complete, in all and from one address.
  std::size_t max_unfinished = 256u << 20, max_unfinished_per_address = 128u << 20;
};

}  // namespace pointreel
