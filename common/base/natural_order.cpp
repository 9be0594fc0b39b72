#include "common/base/natural_order.h"

#include <algorithm>
#include <cstddef>

#include "common/base/letter_case.h"

namespace pointreel {
namespace {

bool is_digit(char c) { return c >= '0' && c <= '9'; }

/// Removes the run of digits at the front of `text` and returns it without leading zeros.
std::string_view take_number(std::string_view& text) {
  const auto end =
      static_cast<std::size_t>(std::find_if_not(text.begin(), text.end(), is_digit) - text.begin());
  std::string_view number = text.substr(0, end);
  text.remove_prefix(end);
  number.remove_prefix(std::min(number.find_first_not_of('0'), number.size()));
  return number;
}

}  // namespace

bool natural_less(std::string_view a, std::string_view b) {
  std::string_view rest_a = a, rest_b = b;
  while (!rest_a.empty() && !rest_b.empty()) {
    if (is_digit(rest_a.front()) && is_digit(rest_b.front())) {
      const std::string_view number_a = take_number(rest_a), number_b = take_number(rest_b);
      if (number_a.size() != number_b.size()) return number_a.size() < number_b.size();
      if (const int order = number_a.compare(number_b); order != 0) return order < 0;
      continue;
    }
    // How a digit compares with a character that is not one does not depend on the digit, so the
    // order stays transitive.
    const auto byte_a = static_cast<unsigned char>(small_letter(rest_a.front()));
    const auto byte_b = static_cast<unsigned char>(small_letter(rest_b.front()));
    if (byte_a != byte_b) return byte_a < byte_b;
    rest_a.remove_prefix(1);
    rest_b.remove_prefix(1);
  }
  if (rest_a.empty() != rest_b.empty()) return rest_a.empty();
  return a < b;
}

bool is_numbered(std::string_view name, std::string_view head, std::size_t digits,
                 std::string_view tail) {
  if (name.size() < head.size() + digits + tail.size() || !name.starts_with(head) ||
      !name.ends_with(tail)) {
    return false;
  }
  name.remove_prefix(head.size());
  name.remove_suffix(tail.size());
  return name.find_first_not_of("0123456789") == std::string_view::npos;
}

}  // namespace pointreel
