#include "client/prepare/leaf_points.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace pointreel {
namespace {

/// Calls `tell` with each leaf and the points in it, sorted.points[begin] to [end - 1].
template <class Tell>
void for_each_leaf(const Svo& svo, const SortedPoints& sorted, const Tell& tell) {
  const int shift = 3 * (sorted.levels - svo.depth);
  std::uint32_t leaf = 0;
  for (std::size_t begin = 0, end = 0; begin < sorted.points.size(); begin = end) {
    const std::uint64_t key = sorted.points[begin].key >> shift;
    while (end < sorted.points.size() && sorted.points[end].key >> shift == key) ++end;
    tell(leaf++, begin, end);
  }
}

}  // namespace

std::vector<float> point_heights(const Svo& svo, const PointCloud& cloud,
                                 const SortedPoints& sorted,
                                 std::span<const glm::i16vec3> normals) {
  const PointCloud centers = leaf_centers(svo);
  const glm::vec3 shift(cloud.origin - centers.origin);
  const auto half = static_cast<float>(0.5 * svo.cell_size(svo.depth));
  std::vector<float> heights(svo.leaf_count());
  for_each_leaf(svo, sorted, [&](std::uint32_t leaf, std::size_t begin, std::size_t end) {
    glm::vec3 offset(0.0f);
    for (std::size_t i = begin; i < end; ++i)
      offset += cloud.positions[sorted.points[i].index] + shift - centers.positions[leaf];
    const glm::vec3 normal = glm::vec3(normals[leaf]) / 32767.0f;
    const float most = half * (std::abs(normal.x) + std::abs(normal.y) + std::abs(normal.z));
    heights[leaf] =
        std::clamp(glm::dot(offset, normal) / static_cast<float>(end - begin), -most, most);
  });
  return heights;
}

std::vector<float> own_radii(const Svo& svo, const PointCloud& cloud, const SortedPoints& sorted) {
  const double least = 0.5 * std::sqrt(3.0) * svo.cell_size(svo.depth);
  std::vector<float> radii(svo.leaf_count());
  for_each_leaf(svo, sorted, [&](std::uint32_t leaf, std::size_t begin, std::size_t end) {
    double area = 0.0;
    for (std::size_t i = begin; i < end; ++i) {
      const double radius = cloud.radii[sorted.points[i].index];
      area += radius * radius;
    }
    const double mean = std::sqrt(area / static_cast<double>(end - begin));
    radii[leaf] = static_cast<float>(std::max(mean, least));
  });
  return radii;
}

}  // namespace pointreel
