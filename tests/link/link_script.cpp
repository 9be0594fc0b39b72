#include "tests/link/link_script.h"

#include <charconv>
#include <cmath>
#include <cstdio>
#include <optional>

#include <fmt/format.h>

namespace pointreel {
namespace {

std::string_view next_word(std::string_view& rest) {
  const auto begin = rest.find_first_not_of(" \t\r");
  if (begin == std::string_view::npos) {
    rest = {};
    return {};
  }
  rest.remove_prefix(begin);
  const auto end = std::min(rest.find_first_of(" \t\r"), rest.size());
  const std::string_view word = rest.substr(0, end);
  rest.remove_prefix(end);
  return word;
}

/// Parses "5", "2.5" or "5M"; nothing if the word is not such a number.
std::optional<double> number(std::string_view word) {
  double unit = 1.0;
  if (!word.empty()) {
    if (word.back() == 'k') unit = 1e3;
    if (word.back() == 'M') unit = 1e6;
    if (word.back() == 'G') unit = 1e9;
    if (unit > 1.0) word.remove_suffix(1);
  }
  double value = 0.0;
  const auto [end, code] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (code != std::errc() || end != word.data() + word.size() || !(value >= 0.0) || value > 1e12)
    return std::nullopt;
  return value * unit;
}

}  // namespace

Result<LinkChange> parse_link_change(std::string_view text) {
  std::string_view rest = text;
  const std::string_view what = next_word(rest);
  const std::string_view argument = next_word(rest);
  const auto wrong = [&](const char* why) { return fail(fmt::format("\"{}\": {}", text, why)); };
  if (!next_word(rest).empty()) return wrong("has more than a name and a number");

  using Kind = LinkChange::Kind;
  for (const auto& [name, kind] : {std::pair{"cut", Kind::cut},
                                   {"restore", Kind::restore},
                                   {"reset", Kind::reset},
                                   {"forget", Kind::forget},
                                   {"clear", Kind::clear}}) {
    if (what != name) continue;
    if (!argument.empty()) return wrong("takes no number");
    return LinkChange{kind, 0.0};
  }
  for (const auto& [name, kind] : {std::pair{"rate", Kind::rate},
                                   {"rate-each", Kind::rate_each},
                                   {"delay", Kind::delay},
                                   {"split", Kind::split},
                                   {"corrupt", Kind::corrupt},
                                   {"truncate", Kind::truncate},
                                   {"reset-after", Kind::reset_after}}) {
    if (what != name) continue;
    const auto value = number(argument);
    if (!value) return wrong("needs a number, as in \"rate 5M\"");
    return LinkChange{kind, *value};
  }
  return wrong("is not an event of a link; see pointreel-link --help");
}

void apply(const LinkChange& change, LinkConditions& conditions) {
  const auto count = static_cast<std::uint64_t>(change.value);
  switch (change.kind) {
    case LinkChange::Kind::rate:
    case LinkChange::Kind::rate_each:
      conditions.bits_per_second = count;
      conditions.rate_each = change.kind == LinkChange::Kind::rate_each;
      break;
    case LinkChange::Kind::delay:
      conditions.delay = std::chrono::microseconds(std::llround(change.value * 1000));
      break;
    case LinkChange::Kind::split:
      conditions.split = count;
      break;
    case LinkChange::Kind::corrupt:
      conditions.corrupt_every = count;
      break;
    case LinkChange::Kind::truncate:
      conditions.truncate_after = count;
      break;
    case LinkChange::Kind::reset_after:
      conditions.reset_after = count;
      break;
    case LinkChange::Kind::cut:
      conditions.cut = true;
      break;
    case LinkChange::Kind::restore:
      conditions.cut = false;
      break;
    case LinkChange::Kind::clear:
      conditions = {};
      break;
    case LinkChange::Kind::reset:
    case LinkChange::Kind::forget:
      break;
  }
}

Result<LinkScript> parse_link_script(std::string_view text) {
  LinkScript script;
  for (int line_number = 1; !text.empty(); ++line_number) {
    const auto end = std::min(text.find('\n'), text.size());
    std::string_view line = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    line = line.substr(0, line.find('#'));
    std::string_view rest = line;
    const std::string_view time = next_word(rest);
    if (time.empty()) continue;
    const auto seconds = number(time);
    const std::string place = fmt::format("line {}", line_number);
    if (!seconds || *seconds > 1e6)
      return fail(fmt::format("{}: \"{}\" is not a time in seconds", place, time));
    rest.remove_prefix(std::min(rest.find_first_not_of(" \t"), rest.size()));
    while (!rest.empty() && (rest.back() == ' ' || rest.back() == '\t' || rest.back() == '\r'))
      rest.remove_suffix(1);
    if (const auto change = parse_link_change(rest); !change) return fail_at(place, change.error());
    script.push_back({std::chrono::milliseconds(std::llround(*seconds * 1000)), std::string(rest)});
  }
  return script;
}

}  // namespace pointreel
