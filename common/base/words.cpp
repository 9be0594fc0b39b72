#include "common/base/words.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

namespace pointreel {
namespace {

/// Without fmt, which would bring locales into the page's module.
std::string text_of(double number, std::chars_format format, int digits) {
  std::array<char, 512> text;  // more than the largest number has digits
  const auto end =
      std::to_chars(text.data(), text.data() + text.size(), number, format, digits).ptr;
  return {text.data(), end};
}

}  // namespace

std::string counted(std::uint64_t count, std::string_view singular, std::string_view plural) {
  std::string text = std::to_string(count) + " ";
  if (count == 1) return text.append(singular);
  return plural.empty() ? text.append(singular) + "s" : text.append(plural);
}

std::string span_text(std::uint64_t least, std::uint64_t most) {
  std::string text = std::to_string(least);
  return least == most ? text : text + " to " + std::to_string(most);
}

std::string number_text(double number, int digits) {
  const double size = std::abs(number);
  if (!(size >= 1e-6 && size < 1e15)) return text_of(number, std::chars_format::general, digits);
  // The position of the last significant digit, after rounding to so many of them: 9.996 to three
  // digits is 10.0.
  const auto exponent = static_cast<int>(std::floor(std::log10(size)));
  const int decimals = digits - 1 - exponent;
  const double unit = std::pow(10.0, -decimals);
  std::string text = text_of(decimals < 0 ? std::round(number / unit) * unit : number,
                             std::chars_format::fixed, std::max(0, decimals));
  if (text.find('.') == std::string::npos) return text;
  text.erase(text.find_last_not_of('0') + 1);
  if (text.ends_with('.')) text.pop_back();
  return text;
}

}  // namespace pointreel
