#pragma once

#include <string>
#include <string_view>

#include "pointreel/error.h"

/// Request targets (RFC 9112, section 3.2) to and from the paths that a catalog knows.
namespace pointreel {

/// The path that an untrusted request target names: `/` and segments, percent-decoded once,
/// without the query. Origin-form (`/a/b?c`) and absolute-form (`http://host/a/b`) are understood.
///
/// Refused, raw or encoded: `.` and `..` segments, slashes and backslashes within a segment,
/// control characters, NUL; and malformed escapes and fragments. The path is only ever looked up
/// in a table of names, so this is the second wall, not the first.
Result<std::string> decode_target(std::string_view target);

/// One path segment as it stands in a URL: everything but unreserved characters escaped.
std::string encode_segment(std::string_view segment);

}  // namespace pointreel
