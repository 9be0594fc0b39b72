#pragma once

#include <charconv>
#include <concepts>
#include <string>
#include <string_view>

namespace pointreel {

/// Joins the parts to one string. Numbers are written in decimal, with as few digits as it takes to
/// read them back exactly. For the rooms of the codec library, which do without fmt.
template <class... Parts>
std::string concat(const Parts&... parts) {
  std::string text;
  const auto add = [&](const auto& part) {
    if constexpr (std::integral<std::decay_t<decltype(part)>>) {
      text += std::to_string(part);
    } else if constexpr (std::floating_point<std::decay_t<decltype(part)>>) {
      char digits[32];
      text.append(digits, std::to_chars(digits, digits + sizeof(digits), part).ptr);
    } else {
      text += std::string_view(part);
    }
  };
  (add(parts), ...);
  return text;
}

}  // namespace pointreel
