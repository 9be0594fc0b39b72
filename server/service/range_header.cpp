#include "server/service/range_header.h"

#include <algorithm>
#include <limits>
#include <optional>

namespace pointreel {
namespace {

std::string_view trim(std::string_view text) {
  const auto first = text.find_first_not_of(" \t");
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t") - first + 1);
}

/// Parses one or more digits. Numbers that are too large saturate, since they lie beyond every end
/// anyway.
std::optional<std::uint64_t> parse_digits(std::string_view text) {
  constexpr auto kMax = std::numeric_limits<std::uint64_t>::max();
  if (text.empty()) return std::nullopt;
  std::uint64_t value = 0;
  for (const char c : text) {
    if (c < '0' || c > '9') return std::nullopt;
    const auto digit = static_cast<std::uint64_t>(c - '0');
    value = value > (kMax - digit) / 10 ? kMax : value * 10 + digit;
  }
  return value;
}

bool is_bytes_unit(std::string_view text) {
  constexpr std::string_view kUnit = "bytes";
  return std::equal(text.begin(), text.end(), kUnit.begin(), kUnit.end(),
                    [](char a, char b) { return (a | 0x20) == b; });
}

}  // namespace

RangeAnswer answer_range(std::string_view field, std::uint64_t size) {
  using Kind = RangeAnswer::Kind;
  const auto equals = field.find('=');
  if (equals == std::string_view::npos || !is_bytes_unit(trim(field.substr(0, equals)))) return {};
  const std::string_view range = trim(field.substr(equals + 1));
  const auto dash = range.find('-');
  if (dash == std::string_view::npos) return {};
  const std::string_view before = range.substr(0, dash), after = range.substr(dash + 1);

  if (before.empty()) {  // "-n": the last n bytes
    const auto suffix = parse_digits(after);
    if (!suffix) return {};
    if (*suffix == 0 || size == 0) return {Kind::kUnsatisfiable};
    const std::uint64_t length = std::min(*suffix, size);
    return {Kind::kPart, size - length, length};
  }
  const auto first = parse_digits(before);
  if (!first) return {};
  auto last = std::numeric_limits<std::uint64_t>::max();
  if (!after.empty()) {
    const auto parsed = parse_digits(after);
    if (!parsed || *parsed < *first) return {};
    last = *parsed;
  }
  if (*first >= size) return {Kind::kUnsatisfiable};
  return {Kind::kPart, *first, std::min(last, size - 1) - *first + 1};
}

}  // namespace pointreel
