#pragma once

#include <cstdint>
#include <cstdlib>
#include <string>

#include "tests/e2e/process.h"

namespace pointreel::e2e {

/// Returns the HOST:PORT that a server without TLS announces in its first line. Empty if that line
/// says something else.
inline std::string server_address(Background& server) {
  const std::string line = server.first_line(), begin = "listening on http://";
  return line.starts_with(begin) ? line.substr(begin.size()) : std::string();
}

/// Returns 0 if there is none.
inline std::uint16_t port_of(const std::string& address) {
  return static_cast<std::uint16_t>(std::atoi(address.c_str() + address.rfind(':') + 1));
}

}  // namespace pointreel::e2e
