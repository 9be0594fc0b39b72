#pragma once

#include <string>
#include <string_view>

#include "pointreel/error.h"

/// Converts request targets (RFC 9112, section 3.2) to and from the paths of a catalog.
namespace pointreel {

/// The path of an untrusted request target, percent-decoded once and without the query. Accepts the
/// origin form (`/a/b?c`) and the absolute form (`http://host/a/b`).
///
/// Refuses `.` and `..` segments, slashes and backslashes within a segment, control characters and
/// NUL, whether encoded or not, and also malformed escapes and fragments. Paths are only looked up
/// in a table of names, so this is a second line of defence.
Result<std::string> decode_target(std::string_view target);

/// Text without its percent-escapes. An error if one is malformed.
Result<std::string> decode_escapes(std::string_view text);

/// A path segment as part of a URL: all characters except unreserved ones are escaped.
std::string encode_segment(std::string_view segment);

/// The path of a URL, which begins with a slash, for segments that are separated by slashes.
std::string encode_path(std::string_view segments);

}  // namespace pointreel
