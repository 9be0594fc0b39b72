#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>

#include <fmt/format.h>

namespace pointreel {

/// "A-B" or "A", where A and B are whole numbers and A <= B: the first and the last frame.
inline std::optional<std::pair<std::uint32_t, std::uint32_t>> parse_frame_numbers(
    const std::string& text) {
  const auto number = [](const std::string& digits) -> std::optional<std::uint32_t> {
    if (digits.empty() || digits.size() > 9 ||
        !std::all_of(digits.begin(), digits.end(), [](char c) { return c >= '0' && c <= '9'; })) {
      return std::nullopt;
    }
    return static_cast<std::uint32_t>(std::stoul(digits));
  };
  const std::size_t dash = text.find('-');
  const auto first = number(text.substr(0, dash));
  const auto last = dash == std::string::npos ? first : number(text.substr(dash + 1));
  if (!first || !last || *first > *last) return std::nullopt;
  return std::pair(*first, *last);
}

inline std::string fault_of_frame_numbers(const std::string& text) {
  return fmt::format("--frames {}: is neither a frame's number, from 0 on, nor A-B with A <= B",
                     text);
}

}  // namespace pointreel
