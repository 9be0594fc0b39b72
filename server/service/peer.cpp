#include "server/service/peer.h"

#include <algorithm>

#include <arpa/inet.h>

namespace pointreel {

Peer peer_of(const std::array<std::uint8_t, 16>& address) {
  static constexpr std::array<std::uint8_t, 12> kMapped = {0, 0, 0, 0, 0,    0,
                                                           0, 0, 0, 0, 0xff, 0xff};
  const bool v4 = std::equal(kMapped.begin(), kMapped.end(), address.begin());
  Peer peer;
  std::array<char, INET6_ADDRSTRLEN> text{};
  if (v4) {
    ::inet_ntop(AF_INET, address.data() + 12, text.data(), text.size());
    peer.loopback = address[12] == 127;
    peer.network = address;
  } else {
    ::inet_ntop(AF_INET6, address.data(), text.data(), text.size());
    peer.loopback =
        address == std::array<std::uint8_t, 16>{0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1};
    std::copy_n(address.begin(), 8, peer.network.begin());
  }
  peer.address = text.data();
  return peer;
}

}  // namespace pointreel
