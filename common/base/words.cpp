#include "common/base/words.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace pointreel {

std::string counted(std::uint64_t count, std::string_view singular, std::string_view plural) {
  if (count == 1) return fmt::format("1 {}", singular);
  if (!plural.empty()) return fmt::format("{} {}", count, plural);
  return fmt::format("{} {}s", count, singular);
}

std::string span_text(std::uint64_t least, std::uint64_t most) {
  return least == most ? fmt::format("{}", least) : fmt::format("{} to {}", least, most);
}

std::string number_text(double number, int digits) {
  const double size = std::abs(number);
  if (!(size >= 1e-6 && size < 1e15)) return fmt::format("{:.{}g}", number, digits);
  // The position of the last significant digit, after rounding to so many of them: 9.996 to three
  // digits is 10.0.
  const auto exponent = static_cast<int>(std::floor(std::log10(size)));
  const int decimals = digits - 1 - exponent;
  const double unit = std::pow(10.0, -decimals);
  std::string text = fmt::format(
      "{:.{}f}", decimals < 0 ? std::round(number / unit) * unit : number, std::max(0, decimals));
  if (text.find('.') == std::string::npos) return text;
  text.erase(text.find_last_not_of('0') + 1);
  if (text.ends_with('.')) text.pop_back();
  return text;
}

}  // namespace pointreel
