#include "codec/package/standing.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace pointreel {
namespace {

/// How far from 0 the soles of what stands there are, as a share of the height.
constexpr double kOnFloor = 0.03;
/// How much taller than wide it is at least.
constexpr double kSlender = 1.3;

bool is_around_0(const Box& box, int axis) { return box.min[axis] < 0.0 && box.max[axis] > 0.0; }

/// `up`: as the frames say. Along its axis, what begins at 0 stands there wherever else it is.
/// Along others, something long may begin at 0 because all coordinates of a map do.
std::optional<Up> standing_direction(const Box& box, Up up) {
  if (box.empty()) return std::nullopt;
  const glm::dvec3 extent = box.extent();
  int longest = 0;
  for (int axis = 1; axis < 3; ++axis)
    if (extent[axis] > extent[longest]) longest = axis;
  for (int axis = 0; axis < 3; ++axis) {
    if (axis == longest) continue;
    if (kSlender * extent[axis] > extent[longest]) return std::nullopt;
    if (longest != up.axis() && !is_around_0(box, axis)) return std::nullopt;
  }
  const double low = std::abs(box.min[longest]), high = std::abs(box.max[longest]);
  if (std::min(low, high) > kOnFloor * extent[longest]) return std::nullopt;
  return Up(static_cast<char>('x' + longest), high < low);
}

}  // namespace

std::optional<std::string> standing_warning(const Box& box, Up up) {
  const auto standing = standing_direction(box, up);
  if (!standing || *standing == up) return std::nullopt;
  return fmt::format("the capture seems to {}; --up {} stands it on its feet",
                     *standing == up.opposite() ? "stand on its head" : "lie on its side",
                     standing->text());
}

}  // namespace pointreel
