#include "client/scene/floor_grid.h"

#include <algorithm>
#include <cmath>

namespace pointreel {
namespace {

/// Radius of the disc in halves of the diagonal of the scene's bounds.
constexpr double kFloorReach = 2.0;
/// The fewest lines between the middle and the rim.
constexpr double kLeastLines = 7.0;
/// Bounds the loop over lines. Steps of 1, 2 and 5 never give more than 2.5 times the fewest.
constexpr int kMostLines = 64;

constexpr float kFaint = 0.5f, kStrong = 1.0f;

double half_diagonal(const Box& bounds) {
  const double half = 0.5 * glm::length(bounds.extent());
  return half > 0.0 && std::isfinite(half) ? half : 0.5 * std::sqrt(3.0);
}

/// The axes along the floor.
glm::ivec2 level_axes(Up up) { return {up.axis() == 0 ? 1 : 0, up.axis() == 2 ? 1 : 2}; }

/// The largest step that is 1, 2 or 5 times a power of ten and no larger than `at_most`.
double round_step(double at_most) {
  const double ten = std::pow(10.0, std::floor(std::log10(at_most)));
  return (at_most >= 5.0 * ten ? 5.0 : at_most >= 2.0 * ten ? 2.0 : 1.0) * ten;
}

/// Cuts off the part behind the near plane. Returns false if nothing is left.
bool clip(glm::dvec3& from, glm::dvec3& to, const glm::dvec3& eye, const glm::dvec3& back,
          double near) {
  const double a = glm::dot(eye - from, back) - near, b = glm::dot(eye - to, back) - near;
  if (a < 0.0 && b < 0.0) return false;
  if (a < 0.0) from += a / (a - b) * (to - from);
  if (b < 0.0) to += b / (b - a) * (from - to);
  return true;
}

}  // namespace

double floor_reach(const Box& bounds) { return kFloorReach * half_diagonal(bounds); }

double floor_step(const Box& bounds) { return round_step(floor_reach(bounds) / kLeastLines); }

glm::dvec3 floor_origin(const FloorGrid& grid) {
  const int up = grid.up.axis();
  glm::dvec3 origin = grid.bounds.center();
  if (!grid.bounds.empty())
    origin[up] = grid.up.reversed() ? grid.bounds.max[up] : grid.bounds.min[up];
  return origin;
}

std::vector<FloorLine> floor_lines(const FloorGrid& grid, const Camera& camera) {
  const glm::dvec3 origin = floor_origin(grid), eye = camera.eye() - origin;
  const glm::dvec3 back = camera.axes()[2];
  const double reach = floor_reach(grid.bounds), step = floor_step(grid.bounds);
  // The next power of ten, at whose multiples lines are stronger.
  const double strong = std::pow(10.0, std::floor(std::log10(step) + 1e-6) + 1.0);
  const glm::ivec2 axes = level_axes(grid.up);
  std::vector<FloorLine> lines;
  for (int i = 0; i < 2; ++i) {
    const int across = axes[i], along = axes[1 - i];
    const double first = std::ceil((origin[across] - reach) / step);
    for (int n = 0; n < kMostLines; ++n) {
      const double world = (first + n) * step, at = world - origin[across];
      if (at > reach) break;
      glm::dvec3 from(0.0);
      from[across] = at;
      glm::dvec3 to = from;
      to[along] = std::sqrt(std::max(0.0, reach * reach - at * at));
      from[along] = -to[along];
      if (!clip(from, to, eye, back, camera.near_plane())) continue;
      const bool is_strong = std::abs(std::remainder(world, strong)) < 0.5 * step;
      lines.push_back({glm::vec3(from), glm::vec3(to), is_strong ? kStrong : kFaint,
                       static_cast<float>(is_strong ? strong : step)});
    }
  }
  return lines;
}

}  // namespace pointreel
