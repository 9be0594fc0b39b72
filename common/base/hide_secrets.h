#pragma once

#include <string>
#include <string_view>

namespace pointreel {

/// Text without what the queries and the users of addresses in it say, which may be signatures,
/// tokens and passwords: "https://HOST/x?..." An address ends at a blank or a quotation mark.
/// Applied to itself it changes nothing.
std::string hide_secrets(std::string_view text);

}  // namespace pointreel
