#include "codec/video_encode/surface_points.h"

#include <algorithm>
#include <cstddef>

#include "codec/core/morton.h"
#include "codec/core/radix_sort.h"

namespace pointreel {
namespace {

SurfacePoints::Columns columns_of(const SurfacePoints& points, int axis) {
  const ViewAxes& axes = kViewAxes[static_cast<std::size_t>(2 * axis)];
  SurfacePoints::Columns columns;
  const auto side = static_cast<std::size_t>(points.side);
  columns.begin.assign(side * side + 1, 0);
  std::vector<std::uint32_t> pixels(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    pixels[i] = static_cast<std::uint32_t>(points.pixel_of(i, axes));
    ++columns.begin[pixels[i] + 1];
  }
  for (std::size_t p = 0; p < side * side; ++p) columns.begin[p + 1] += columns.begin[p];
  columns.points.resize(points.size());
  std::vector<std::uint32_t> next(columns.begin.begin(), columns.begin.end() - 1);
  for (std::size_t i = 0; i < points.size(); ++i)
    columns.points[next[pixels[i]]++] = static_cast<std::uint32_t>(i);
  const auto depth = [&](std::uint32_t i) { return points.places[i][axis]; };
  for (std::size_t p = 0; p < side * side; ++p) {
    const auto first = columns.points.begin() + columns.begin[p],
               end = columns.points.begin() + columns.begin[p + 1];
    if (first == end) continue;
    columns.used.push_back(static_cast<std::uint32_t>(p));
    if (end - first > 1)
      std::sort(first, end,
                [&](auto a, auto b) { return depth(a) != depth(b) ? depth(a) < depth(b) : a < b; });
  }
  return columns;
}

}  // namespace

SurfacePoints surface_points(const PointCloud& cloud, const glm::dvec3& corner, double pitch,
                             int side) {
  SurfacePoints points;
  points.side = side;
  std::vector<glm::vec3> places;
  std::vector<KeyIndex> order;
  places.reserve(cloud.size());
  order.reserve(cloud.size());
  const float most = static_cast<float>(side) - 0.01f;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    places.push_back(glm::clamp(glm::vec3((cloud.world(i) - corner) / pitch), 0.0f, most));
    order.emplace_back(
        morton_encode(glm::uvec3(places.back()) / std::uint32_t{SurfacePoints::kCell}),
        static_cast<std::uint32_t>(i));
  }
  radix_sort(order);
  points.source.reserve(cloud.size());
  points.places.reserve(cloud.size());
  points.normals.reserve(cloud.size());
  points.colors.reserve(cloud.colors.size());
  for (std::size_t i = 0; i < order.size(); ++i) {
    const std::uint32_t from = order[i].index;
    points.source.push_back(from);
    points.places.push_back(places[from]);
    points.normals.push_back(cloud.normals[from]);
    if (cloud.has_colors()) points.colors.push_back(cloud.colors[from]);
    if (i == 0 || order[i].key != order[i - 1].key)
      points.cell_begin.push_back(static_cast<std::uint32_t>(i));
  }
  points.cell_begin.push_back(static_cast<std::uint32_t>(order.size()));
  if (!places.empty()) points.least = points.most = glm::ivec3(places.front());
  for (const glm::vec3& place : places) {
    points.least = glm::min(points.least, glm::ivec3(place));
    points.most = glm::max(points.most, glm::ivec3(place));
  }
  for (int axis = 0; axis < 3; ++axis)
    points.columns[static_cast<std::size_t>(axis)] = columns_of(points, axis);
  return points;
}

}  // namespace pointreel
