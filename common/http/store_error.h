#pragma once

#include <string>
#include <string_view>

namespace pointreel {

/// The code in the answer of an object store that refuses a request, such as "NoSuchBucket" in
/// <Error><Code>NoSuchBucket</Code>...</Error>. Empty if there is none.
///
/// Trust: the answer may be hostile, cut off, and no XML at all. A code has 1 to 64 letters and
/// digits.
std::string store_error_code(std::string_view answer);

/// What to do about it; empty if that is not known.
const char* advice_for(std::string_view code);

}  // namespace pointreel
