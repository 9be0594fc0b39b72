#pragma once

#include <array>
#include <cstdint>
#include <string>

namespace pointreel {

/// Who is at the other end of a connection.
struct Peer {
  std::string address;    ///< in digits, for people
  bool loopback = false;  ///< it is on this machine
  /// What limits for each address go by: the address, or of IPv6 the first 64 bits, for the others
  /// are the peer's to choose.
  std::array<std::uint8_t, 16> network{};
};

/// From the binary form of an IPv6 address; IPv4 is mapped into it (::ffff:a.b.c.d).
Peer peer_of(const std::array<std::uint8_t, 16>& address);

}  // namespace pointreel
