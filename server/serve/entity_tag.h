#pragma once

#include <cstdint>
#include <string>
#include <string_view>

/// Entity tags and the conditions that name them: RFC 9110, sections 8.8.3 and 13.1.
namespace pointreel {

/// `"0123456789abcdef"`: a strong tag from a 64-bit checksum of the content.
std::string make_etag(std::uint64_t checksum);

/// True if a list of tags (the value of If-None-Match; untrusted) is `*` or holds `etag`, weak
/// tags compared as if strong. A list that is malformed matches nothing from there on.
bool matches_weakly(std::string_view list, std::string_view etag);

/// The same for If-Match and If-Range: a weak tag, or a date, never matches.
bool matches_strongly(std::string_view list, std::string_view etag);

}  // namespace pointreel
