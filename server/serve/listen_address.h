#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "pointreel/error.h"

namespace pointreel {

/// Where a server listens.
struct ListenAddress {
  std::string host = "127.0.0.1";  ///< an IPv4 or IPv6 address in digits, without brackets
  std::uint16_t port = 8090;       ///< 0: any free port
  bool operator==(const ListenAddress&) const = default;
};

/// Parses "127.0.0.1:8090", "[::1]:8090" or "localhost:8090" (which is 127.0.0.1). Other names are
/// not looked up, because a server listens on addresses of its own machine.
Result<ListenAddress> parse_listen_address(std::string_view text);

/// Whether only this machine can reach the address.
bool is_loopback(const ListenAddress& address);

/// An address at which a browser can reach the server: the same, or for "all addresses of this
/// machine" its first one that is not of loopback.
ListenAddress reachable_address(const ListenAddress& address);

/// "127.0.0.1:8090", "[::1]:8090".
std::string to_string(const ListenAddress& address);

}  // namespace pointreel
