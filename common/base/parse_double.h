#pragma once

#include <charconv>
#include <cstdlib>
#include <string>
#include <system_error>

namespace pointreel {

/// std::from_chars, which clang's library does not have for floating point numbers. `begin` to
/// `end`: a number, perhaps with something behind it.
inline std::from_chars_result parse_double(const char* begin, const char* end, double& value) {
#if defined(__cpp_lib_to_chars)
  return std::from_chars(begin, end, value);
#else
  // Unlike from_chars, strtod takes spaces, a plus and hexadecimal digits, and needs an end.
  const std::string text(begin, end);
  const std::size_t sign = text.starts_with('-') ? 1 : 0;
  const char first = sign < text.size() ? text[sign] : '\0';
  const char second = sign + 1 < text.size() ? text[sign + 1] : '\0';
  const bool begins =
      (first >= '0' && first <= '9') || first == '.' || (first | 32) == 'i' || (first | 32) == 'n';
  if (!begins) return {begin, std::errc::invalid_argument};
  if (first == '0' && (second | 32) == 'x') {
    value = 0.0;
    return {begin + sign + 1, std::errc()};
  }
  char* rest = nullptr;
  const double parsed = std::strtod(text.c_str(), &rest);
  const char* const stop = begin + (rest - text.c_str());
  if (stop == begin) return {begin, std::errc::invalid_argument};
  const bool digits = (first >= '0' && first <= '9') || first == '.';
  const bool nonzero = text.find_first_of("123456789") < text.find_first_of("eE") && digits;
  const bool too_large = digits && !(parsed - parsed == 0.0);
  if (too_large || (nonzero && parsed == 0.0)) return {stop, std::errc::result_out_of_range};
  value = parsed;
  return {stop, std::errc()};
#endif
}

}  // namespace pointreel
