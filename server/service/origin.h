#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "pointreel/error.h"

namespace pointreel {

/// Decides which pages in browsers may use the server. A browser lets any page send requests to any
/// server that its machine can reach, also to one that listens on loopback, and tells the server
/// the page's origin (RFC 6454). Programs send no origin.
///
/// Trust: origins and hosts are untrusted. They are compared; an answer repeats only an origin that
/// is allowed.
class Origins {
 public:
  /// `allowed`: origins such as "https://example.org:8443", or "*" for all.
  static Result<Origins> parse(const std::vector<std::string>& allowed);

  /// Whether a server that listens on loopback alone answers for this host (the value of the Host
  /// field): for the names of loopback and the hosts of allowed origins. Otherwise a page could let
  /// its own name point to this machine ("DNS rebinding"), and would then count as the server's
  /// own.
  bool answers_on_loopback_for(std::string_view host) const;

  /// Whether a page of this origin (the value of the Origin field, empty for programs) may connect.
  bool allows(std::string_view origin, std::string_view host) const;

  /// The header lines of a response that tell a browser what the page may do with it (the Fetch
  /// standard, "CORS protocol"). `preflight`: the response is to OPTIONS.
  std::string fields(std::string_view origin, bool preflight) const;

 private:
  bool lists(std::string_view origin) const;

  bool any_ = false;
  std::vector<std::string> origins_, hosts_;  ///< in lower case; hosts without ports
};

/// Which pages may show the server's own page in a frame, as the directive frame-ancestors of a
/// Content-Security-Policy has it: those of the server itself and of `allowed`, which are as above.
Result<std::string> parse_frame_ancestors(const std::vector<std::string>& allowed);

}  // namespace pointreel
