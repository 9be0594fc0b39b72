#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "pointreel/error.h"

namespace pointreel {

/// An absolute address, such as wss://host:8090/live/NAME?publish.
struct Url {
  std::string scheme;      ///< in lower case: "http", "https", "ws", "wss", or any other
  std::string user;        ///< the part between :// and an @ before the host; usually empty
  std::string host;        ///< an IPv6 address is without its brackets
  std::uint16_t port = 0;  ///< 443 with TLS and 80 without, unless the address names one
  std::string target;      ///< path and query, at least "/"

  bool is_http() const { return scheme == "http" || scheme == "https"; }
  bool is_websocket() const { return scheme == "ws" || scheme == "wss"; }
  bool tls() const { return scheme == "https" || scheme == "wss"; }
  /// "host:port", for people and for a Host header. An IPv6 address is in brackets.
  std::string place() const;
};

/// The part before "://". Returns an empty view if there is none, as in a path.
std::string_view scheme_of(std::string_view text);

/// Parses an address and leaves out its fragment. Blanks and control characters are errors, since
/// they would break a request. Errors have the code `argument` and begin with the text.
Result<Url> parse_url(const std::string& text);

/// An error (`argument`) if a bearer token has a blank or a control character, for the same reason.
Result<void> check_token(std::string_view token);

/// An address as it may be printed: without what its query says, which may be a signature, and
/// without its user. What is no address, such as the path of a file, stays as it is.
std::string without_secrets(const std::string& url);

}  // namespace pointreel
