#pragma once

#include <array>
#include <cstdint>
#include <string>

namespace pointreel {

/// The other end of a connection.
struct Peer {
  std::string address;    ///< numeric, for people
  bool loopback = false;  ///< the peer is on this machine
  /// What limits for each address apply to: the address, or the first 64 bits of an IPv6 address,
  /// because a peer can choose the others freely.
  std::array<std::uint8_t, 16> network{};
};

/// From the binary form of an IPv6 address. IPv4 addresses are mapped into IPv6 (::ffff:a.b.c.d).
Peer peer_of(const std::array<std::uint8_t, 16>& address);

}  // namespace pointreel
