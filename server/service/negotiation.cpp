#include "server/service/negotiation.h"

#include <algorithm>

#include <strings.h>

namespace pointreel {
namespace {

std::string_view trimmed(std::string_view text) {
  constexpr std::string_view kBlank = " \t";
  const auto first = text.find_first_not_of(kBlank);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kBlank) - first + 1);
}

bool same(std::string_view a, std::string_view b) {
  return a.size() == b.size() && ::strncasecmp(a.data(), b.data(), a.size()) == 0;
}

/// Takes what stands before the next separator, or the rest.
std::string_view take(std::string_view& rest, char separator) {
  const auto end = std::min(rest.find(separator), rest.size());
  const std::string_view part = rest.substr(0, end);
  rest.remove_prefix(std::min(end + 1, rest.size()));
  return trimmed(part);
}

/// "q=0", "q=0.", "q=0.000"
bool is_zero_quality(std::string_view parameter) {
  const std::string_view name = take(parameter, '=');
  const std::string_view weight = trimmed(parameter);
  return same(name, "q") && weight.starts_with('0') &&
         weight.find_first_not_of("0.") == std::string_view::npos;
}

}  // namespace

bool names_acceptable(std::string_view list, std::string_view value) {
  while (!list.empty()) {
    std::string_view item = take(list, ',');
    if (!same(take(item, ';'), value)) continue;
    bool refused = false;
    while (!item.empty()) refused = is_zero_quality(take(item, ';')) || refused;
    return !refused;
  }
  return false;
}

}  // namespace pointreel
