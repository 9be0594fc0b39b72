#include "codec/video_encode/surface_points.h"

#include <algorithm>

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
  points.places.reserve(cloud.size());
  const float most = static_cast<float>(side) - 0.01f;
  for (std::size_t i = 0; i < cloud.size(); ++i)
    points.places.push_back(glm::clamp(glm::vec3((cloud.world(i) - corner) / pitch), 0.0f, most));
  points.normals = cloud.normals;
  for (const glm::u16vec3& color : cloud.colors) points.colors.push_back(glm::vec3(color) / 257.0f);
  for (int axis = 0; axis < 3; ++axis)
    points.columns[static_cast<std::size_t>(axis)] = columns_of(points, axis);
  return points;
}

}  // namespace pointreel
