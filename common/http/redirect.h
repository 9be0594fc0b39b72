#pragma once

#include <string>

namespace pointreel {

/// Where a redirect of HTTP leads, and whether it is followed.
struct Redirect {
  enum class Verdict {
    follow,
    another_host,
    not_secure,  ///< from https to anything else
    not_http,    ///< from http to anything but http and https
  };
  Verdict verdict = Verdict::follow;
  std::string to;  ///< for people; empty if it is followed
};

/// `from` is the address that was asked, and `location` the answer's Location. Any path, port and
/// user of the same host is followed, also from http to https.
///
/// Trust: the location may be hostile. It is parsed by curl itself, so that what is judged is what
/// would be asked.
Redirect judge_redirect(const std::string& from, const std::string& location, bool to_other_hosts);

}  // namespace pointreel
