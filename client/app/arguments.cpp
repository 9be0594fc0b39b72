#include "client/app/arguments.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <system_error>

#include <fmt/format.h>
#include <glm/trigonometric.hpp>

#include "client/options/option_table.h"
#include "client/options/option_text.h"
#include "client/scene/named_views.h"
#include "common/base/try.h"
#include "pointreel/cloud.h"

namespace pointreel {

Result<CameraArgument> parse_camera(const std::string& text) {
  for (const NamedView& named : kNamedViews)
    if (named.name == text) return View{named.yaw, named.pitch};
  // The camera can look straight up or down, but not over its head.
  std::array<double, 2> angles{};
  const bool numbers = parse_numbers(text, ',', angles);
  if (numbers && std::isfinite(angles[0]) && std::abs(angles[1]) <= 90.0)
    return View{glm::radians(angles[0]), glm::radians(angles[1])};
  std::error_code ignored;
  if (!numbers && std::filesystem::exists(text, ignored)) return TRY(load_camera_path(text));
  return fail(ErrorCode::argument,
              fmt::format("\"{}\" is not a view; give front, back, left, right, top, bottom, "
                          "YAW,PITCH in degrees with a pitch from -90 to 90, or a file with a "
                          "camera path",
                          text));
}

Result<glm::dvec2> parse_interval(const std::string& text) {
  std::array<double, 2> ends{};
  if (!parse_numbers(text, ',', ends) || !std::isfinite(ends[0]) || !std::isfinite(ends[1]) ||
      !(ends[0] < ends[1]))
    return fail(ErrorCode::argument,
                fmt::format("\"{}\" is not two numbers such as 0,255, the lower one first", text));
  return glm::dvec2(ends[0], ends[1]);
}

Result<void> set_color(const std::string& text, Settings& settings) {
  settings.scalar.field.clear();
  const Result<void> known = set_from_text(find_option("color"), text, settings);
  if (known || !is_scalar_name(text)) return known;
  settings.draw.color = ColorSource::colors;
  settings.scalar.field = text;
  return {};
}

Result<glm::dvec3> parse_position(const std::string& text) {
  std::array<double, 3> position{};
  const auto in_range = [](double number) { return std::abs(number) <= 1e9; };
  if (!parse_numbers(text, ',', position) ||
      !std::all_of(position.begin(), position.end(), in_range))
    return fail(ErrorCode::argument,
                fmt::format("\"{}\" is not a position such as -0.5,0,1.5", text));
  return glm::dvec3(position[0], position[1], position[2]);
}

Result<Target> parse_target(const std::string& text) {
  for (const auto& [name, height] : kNamedHeights)
    if (text == name) return height;
  if (const auto position = parse_position(text)) return *position;
  return fail(
      ErrorCode::argument,
      fmt::format("\"{}\" is neither a point such as -0.5,0,1.5 nor feet, middle or head", text));
}

}  // namespace pointreel
