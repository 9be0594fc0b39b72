#pragma once

#include <cstdint>
#include <string>
#include <string_view>

/// Entity tags and the conditions that use them: RFC 9110, sections 8.8.3 and 13.1.
namespace pointreel {

/// A strong tag, such as `"0123456789abcdef"`, from a 64-bit checksum of the content.
std::string make_etag(std::uint64_t checksum);

/// True if a list of tags (the untrusted value of If-None-Match) is `*` or contains `etag`. Weak
/// tags are compared as if they were strong. Where the list is malformed, the rest of it matches
/// nothing.
bool matches_weakly(std::string_view list, std::string_view etag);

/// The same for If-Match and If-Range: a weak tag, or a date, never matches.
bool matches_strongly(std::string_view list, std::string_view etag);

}  // namespace pointreel
