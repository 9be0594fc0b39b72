#pragma once

#include <array>
#include <charconv>
#include <cstddef>
#include <string>
#include <string_view>
#include <system_error>

#include <glm/glm.hpp>

#include "client/options/option_table.h"
#include "pointreel/error.h"

/// Values of options as they are written on the command line.
namespace pointreel {

/// "on", "0.72", "surfel", "#1c1f24", "1280x720".
std::string value_text(const Option& option, const Settings& settings);

/// What the option accepts, for --help: "0 to 1"; "surfel, voxel, point". Empty for flags.
std::string accepted_values(const Option& option);

/// Flags are "true" or "false", other values as value_text gives them. The error quotes the text
/// and says what is accepted.
Result<void> set_from_text(const Option& option, std::string_view text, Settings& settings);

/// A number in the range.
Result<double> parse_number(std::string_view text, const Range& range);
/// "1280x720", both sides in the range.
Result<glm::ivec2> parse_size(std::string_view text, const Range& range);
/// "#1c1f24", also without "#", as sRGB from 0 to 1.
Result<glm::vec3> parse_color(std::string_view text);
std::string color_text(const glm::vec3& color);

/// Reads as many numbers as `values` holds, with a separator between any two. False if the text is
/// anything else, or if a number does not fit.
template <class Number, std::size_t kCount>
bool parse_numbers(std::string_view text, char separator, std::array<Number, kCount>& values) {
  const char *at = text.data(), *const end = at + text.size();
  for (std::size_t i = 0; i < kCount; ++i) {
    if (i > 0 && (at == end || *at++ != separator)) return false;
    const auto number = std::from_chars(at, end, values[i]);
    if (number.ec != std::errc()) return false;
    at = number.ptr;
  }
  return at == end;
}

}  // namespace pointreel
