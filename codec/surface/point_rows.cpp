#include "codec/surface/point_rows.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace pointreel {
namespace {

PointRow row_of(std::span<const PointNormal> all, std::span<std::uint32_t> points) {
  // In an order of their own, whatever the order in which they were found.
  std::sort(points.begin(), points.end());
  PointRow row;
  row.count = static_cast<std::uint32_t>(points.size());
  glm::vec3 least = all[points[0]].position, most = least;
  for (const std::uint32_t i : points) {
    least = glm::min(least, all[i].position);
    most = glm::max(most, all[i].position);
  }
  row.center = 0.5f * (least + most);
  float square = 0.0f;
  for (std::size_t lane = 0; lane < kLanes; ++lane) {
    const bool there = lane < points.size();
    row.points[lane] = points[there ? lane : 0];
    const glm::vec3 position =
        there ? all[points[lane]].position : glm::vec3(std::numeric_limits<float>::infinity());
    row.x[lane] = position.x;
    row.y[lane] = position.y;
    row.z[lane] = position.z;
    const glm::vec3 d = position - row.center;
    if (there) square = std::max(square, glm::dot(d, d));
  }
  // A little more than all roundings.
  row.radius = 1.0001f * std::sqrt(square);
  return row;
}

/// Splits the points where their extent is largest until they fit a row.
void split(std::span<const PointNormal> all, std::span<std::uint32_t> points,
           std::vector<PointRow>& rows) {
  if (points.size() <= kLanes) {
    rows.push_back(row_of(all, points));
    return;
  }
  glm::vec3 least = all[points[0]].position, most = least;
  for (const std::uint32_t i : points) {
    least = glm::min(least, all[i].position);
    most = glm::max(most, all[i].position);
  }
  const glm::vec3 extent = most - least;
  const glm::length_t axis =
      extent.x >= extent.y ? (extent.x >= extent.z ? 0 : 2) : (extent.y >= extent.z ? 1 : 2);
  const std::size_t full_rows = points.size() / kLanes;
  const std::size_t half = (full_rows + 1) / 2 * kLanes;
  const auto before = [&](std::uint32_t a, std::uint32_t b) {
    const float x = all[a].position[axis], y = all[b].position[axis];
    return x < y || (x == y && a < b);
  };
  std::nth_element(points.begin(), points.begin() + static_cast<std::ptrdiff_t>(half), points.end(),
                   before);
  split(all, points.first(half), rows);
  split(all, points.subspan(half), rows);
}

}  // namespace

void append_rows(std::span<const PointNormal> all, std::span<std::uint32_t> points,
                 std::vector<PointRow>& rows) {
  if (!points.empty()) split(all, points, rows);
}

}  // namespace pointreel
