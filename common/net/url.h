#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "pointreel/error.h"

namespace pointreel {

/// An absolute address, such as wss://host:8090/live/NAME?publish.
struct Url {
  std::string scheme;      ///< in lower case: "http", "https", "ws", "wss", or any other
  std::string user;        ///< what stands before an @ in front of the host; mostly empty
  std::string host;        ///< an IPv6 address without its brackets
  std::uint16_t port = 0;  ///< if not given: 443 with TLS, 80 without
  std::string target;      ///< path and query, at least "/"

  bool is_http() const { return scheme == "http" || scheme == "https"; }
  bool is_websocket() const { return scheme == "ws" || scheme == "wss"; }
  bool tls() const { return scheme == "https" || scheme == "wss"; }
  /// "host:port", for people and for a Host header; an IPv6 address stands in brackets.
  std::string place() const;
};

/// What stands before "://"; empty where that is not there: `text` is a path then.
std::string_view scheme_of(std::string_view text);

/// Fragments are left out. Refuses blanks and control characters, which have no place in a request.
/// Errors begin with the text.
Result<Url> parse_url(const std::string& text);

}  // namespace pointreel
