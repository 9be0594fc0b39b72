#include "client/options/option_text.h"

#include <algorithm>
#include <cstdint>
#include <variant>

#include <fmt/format.h>

#include "common/base/try.h"
#include "common/base/words.h"

namespace pointreel {
namespace {

std::string text_of(const Option::Flag& flag, const Settings& from) {
  return flag.get(from) ? "on" : "off";
}
std::string text_of(const Option::Number& number, const Settings& from) {
  return fmt::format("{:g}", number.get(from));
}
std::string text_of(const Option::Choice& choice, const Settings& from) {
  return choice.names[choice.get(from)];
}
std::string text_of(const Option::Color& color, const Settings& from) {
  return color_text(color.get(from));
}
std::string text_of(const Option::Size& size, const Settings& from) {
  return fmt::format("{}x{}", size.get(from).x, size.get(from).y);
}

std::string accepted(const Option::Flag&) { return {}; }
std::string accepted(const Option::Number& number) {
  return fmt::format("{} to {}", number_text(number.range.min), number_text(number.range.max));
}
std::string accepted(const Option::Choice& choice) {
  return fmt::format("{}", fmt::join(choice.names, ", "));
}
std::string accepted(const Option::Color&) { return "#RRGGBB"; }
std::string accepted(const Option::Size&) { return "WIDTHxHEIGHT"; }

Result<void> set(const Option::Flag& flag, std::string_view text, Settings& to) {
  flag.set(to, text == "true");
  return {};
}
Result<void> set(const Option::Number& number, std::string_view text, Settings& to) {
  number.set(to, TRY(parse_number(text, number.range)));
  return {};
}
Result<void> set(const Option::Choice& choice, std::string_view text, Settings& to) {
  const auto found = std::find(choice.names.begin(), choice.names.end(), text);
  if (found == choice.names.end())
    return fail(ErrorCode::argument,
                fmt::format("\"{}\" is not one of {}", text, fmt::join(choice.names, ", ")));
  choice.set(to, static_cast<std::size_t>(found - choice.names.begin()));
  return {};
}
Result<void> set(const Option::Color& color, std::string_view text, Settings& to) {
  color.set(to, TRY(parse_color(text)));
  return {};
}
Result<void> set(const Option::Size& size, std::string_view text, Settings& to) {
  size.set(to, TRY(parse_size(text, size.range)));
  return {};
}

}  // namespace

std::string value_text(const Option& option, const Settings& settings) {
  return std::visit([&](const auto& value) { return text_of(value, settings); }, option.value);
}

std::string accepted_values(const Option& option) {
  return std::visit([](const auto& value) { return accepted(value); }, option.value);
}

Result<void> set_from_text(const Option& option, std::string_view text, Settings& settings) {
  return std::visit([&](const auto& value) { return set(value, text, settings); }, option.value);
}

Result<double> parse_number(std::string_view text, const Range& range) {
  std::array<double, 1> number{};
  if (!parse_numbers(text, ',', number) || !range.contains(number[0]))
    return fail(ErrorCode::argument, fmt::format("\"{}\" is not a number from {} to {}", text,
                                                 number_text(range.min), number_text(range.max)));
  return number[0];
}

Result<glm::ivec2> parse_size(std::string_view text, const Range& range) {
  std::array<int, 2> size{};
  if (!parse_numbers(text, 'x', size) || !range.contains(size[0]) || !range.contains(size[1]))
    return fail(ErrorCode::argument,
                fmt::format("\"{}\" is not a size such as 1280x720 with sides from {:g} to {:g}",
                            text, range.min, range.max));
  return glm::ivec2(size[0], size[1]);
}

Result<glm::vec3> parse_color(std::string_view text) {
  const std::string_view digits = text.substr(text.starts_with('#') ? 1 : 0);
  const char* const end = digits.data() + digits.size();
  std::uint32_t color = 0;
  const auto parsed = std::from_chars(digits.data(), end, color, 16);
  if (parsed.ec != std::errc() || parsed.ptr != end || digits.size() != 6)
    return fail(ErrorCode::argument, fmt::format("\"{}\" is not a colour such as #1c1f24", text));
  return glm::vec3(color >> 16, color >> 8 & 0xff, color & 0xff) / 255.0f;
}

std::string color_text(const glm::vec3& color) {
  const glm::ivec3 c(glm::round(glm::clamp(color, 0.0f, 1.0f) * 255.0f));
  return fmt::format("#{:02x}{:02x}{:02x}", c.r, c.g, c.b);
}

}  // namespace pointreel
