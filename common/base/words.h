#pragma once

#include <cstdint>
#include <string>
#include <string_view>

/// How numbers are written for people.
namespace pointreel {

/// "1 frame", "2 frames". `plural` is needed where it is not the singular with an s.
std::string counted(std::uint64_t count, std::string_view singular, std::string_view plural = {});

/// "3 to 7", or "3" where both are the same.
std::string span_text(std::uint64_t least, std::uint64_t most);

/// A number with that many significant digits, and without an exponent wherever it can be read so:
/// 0.00025, 5411930, 1.5e-09.
std::string number_text(double number, int digits = 6);

}  // namespace pointreel
