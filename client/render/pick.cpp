#include "client/render/pick.h"

#include <cmath>
#include <cstddef>

namespace pointreel {
namespace {

/// How many pixels away something is looked for.
constexpr int kPickReach = 8;

}  // namespace

PixelRect pick_area(const glm::dvec2& at, glm::ivec2 size) {
  if (!(at.x >= 0.0 && at.x <= size.x && at.y >= 0.0 && at.y <= size.y)) return {};
  const glm::ivec2 middle = glm::min(glm::ivec2(at), size - 1);
  return {glm::max(middle - kPickReach, 0), glm::min(middle + kPickReach + 1, size)};
}

std::optional<glm::dvec3> pick(const glm::dvec2& at, const PixelRect& area,
                               std::span<const float> depths, const Camera& camera,
                               glm::ivec2 size) {
  const glm::ivec2 middle = glm::min(glm::ivec2(at), size - 1);
  double nearest = kPickReach + 0.5;
  glm::dvec2 found(0.0);
  float found_depth = 0.0f;
  std::size_t i = 0;
  for (int y = area.min.y; y < area.max.y; ++y) {
    for (int x = area.min.x; x < area.max.x; ++x) {
      const float there = depths[i++];
      const glm::ivec2 here(x, y);
      const double away = glm::length(glm::dvec2(here - middle));
      if (!(there > 0.0f) || away >= nearest) continue;
      nearest = away;
      found = here == middle ? at : glm::dvec2(here) + 0.5;
      found_depth = there;
    }
  }
  if (found_depth == 0.0f) return std::nullopt;
  const double t = std::tan(0.5 * camera.fov_y), away = camera.near_plane() / found_depth;
  const glm::dvec2 in_picture = (2.0 * found - glm::dvec2(size)) / static_cast<double>(size.y);
  const glm::dmat3 axes = camera.axes();
  return camera.eye() + away * (t * (in_picture.x * axes[0] + in_picture.y * axes[1]) - axes[2]);
}

}  // namespace pointreel
