#pragma once

#include <string_view>

/// Proactive content negotiation: RFC 9110, section 12.5.
namespace pointreel {

/// Whether the untrusted value of Accept or Accept-Encoding names `value`, such as "text/html" or
/// "br", and not with a quality of 0. Ranges such as `*/*` do not count: programs send them, too.
bool names_acceptable(std::string_view list, std::string_view value);

}  // namespace pointreel
