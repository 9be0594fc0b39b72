#include "codec/files/file_numbers.h"

#include <algorithm>
#include <cstddef>
#include <optional>
#include <string_view>

#include "common/base/concat.h"
#include "common/base/letter_case.h"

namespace pointreel {
namespace {

bool is_digit(char c) { return c >= '0' && c <= '9'; }

struct NameParts {
  std::vector<std::string> texts;  ///< around the numbers
  std::vector<std::uint64_t> numbers;
};

/// Nothing for numbers that are too large to count with.
std::optional<NameParts> parts_of_name(std::string_view name) {
  constexpr std::size_t kMostDigits = 18;
  NameParts parts{{std::string()}, {}};
  for (std::size_t at = 0; at < name.size();) {
    if (!is_digit(name[at])) {
      parts.texts.back() += small_letter(name[at++]);
      continue;
    }
    const std::size_t begin = at;
    std::uint64_t number = 0;
    for (; at < name.size() && is_digit(name[at]); ++at)
      number = 10 * number + static_cast<std::uint64_t>(name[at] - '0');
    if (at - begin > kMostDigits) return std::nullopt;
    parts.numbers.push_back(number);
    parts.texts.emplace_back();
  }
  return parts;
}

/// Rising numbers, and the step between neighbours.
struct Numbers {
  std::vector<std::uint64_t> values;
  std::uint64_t step = 1;
};

std::optional<Numbers> numbers_of(std::span<const std::string> names) {
  if (names.size() < 3) return std::nullopt;
  std::vector<NameParts> all;
  for (const std::string& name : names) {
    auto parts = parts_of_name(name);
    if (!parts || (!all.empty() && parts->texts != all.front().texts)) return std::nullopt;
    all.push_back(std::move(*parts));
  }
  const std::size_t count = all.front().numbers.size();
  std::size_t counting = count;
  for (std::size_t i = 0; i < count; ++i) {
    const bool differs = std::any_of(all.begin(), all.end(), [&](const NameParts& parts) {
      return parts.numbers[i] != all.front().numbers[i];
    });
    if (differs && counting != count) return std::nullopt;
    if (differs) counting = i;
  }
  if (counting == count) return std::nullopt;
  Numbers numbers;
  std::vector<std::uint64_t> steps;
  for (const NameParts& parts : all) {
    const std::uint64_t value = parts.numbers[counting];
    if (!numbers.values.empty()) {
      if (value <= numbers.values.back()) return std::nullopt;
      steps.push_back(value - numbers.values.back());
    }
    numbers.values.push_back(value);
  }
  numbers.step = *std::min_element(steps.begin(), steps.end());
  const auto usual = std::count(steps.begin(), steps.end(), numbers.step);
  const bool multiples = std::all_of(steps.begin(), steps.end(),
                                     [&](std::uint64_t step) { return step % numbers.step == 0; });
  if (!multiples || 2 * usual < std::ssize(steps)) return std::nullopt;
  return numbers;
}

}  // namespace

std::vector<std::uint64_t> places_by_number(std::span<const std::string> names) {
  std::vector<std::uint64_t> places;
  if (const auto numbers = numbers_of(names)) {
    for (const std::uint64_t value : numbers->values)
      places.push_back((value - numbers->values.front()) / numbers->step);
  }
  return places;
}

std::string missing_numbers(std::span<const std::string> names) {
  constexpr std::size_t kMostRanges = 8;
  std::string text;
  const auto numbers = numbers_of(names);
  if (!numbers) return text;
  std::size_t ranges = 0;
  for (std::size_t i = 1; i < numbers->values.size(); ++i) {
    const std::uint64_t first = numbers->values[i - 1] + numbers->step;
    const std::uint64_t last = numbers->values[i] - numbers->step;
    if (first > last || ++ranges > kMostRanges) continue;
    text += concat(text.empty() ? "" : ", ", first);
    if (last > first) text += concat(" to ", last);
  }
  if (ranges > kMostRanges) text += concat(" and ", ranges - kMostRanges, " more gaps");
  return text;
}

}  // namespace pointreel
