#include "tests/stability/clouds.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "codec/core/build.h"
#include "datasets_synthetic/random.h"
#include "pointreel/cloud.h"
#include "pointreel/draco.h"
#include "pointreel/octree.h"

namespace pointreel::stability {

PointCloud ball_cloud(std::size_t count, const glm::dvec3& center) {
  PointCloud cloud;
  cloud.origin = center;
  const double golden = 3.141592653589793 * (3.0 - std::sqrt(5.0));
  for (std::size_t i = 0; i < count; ++i) {
    const double y = 1.0 - (2.0 * static_cast<double>(i) + 1.0) / static_cast<double>(count);
    const double r = std::sqrt(1.0 - y * y), turn = golden * static_cast<double>(i);
    const glm::vec3 n(static_cast<float>(r * std::cos(turn)), static_cast<float>(y),
                      static_cast<float>(r * std::sin(turn)));
    cloud.positions.push_back(0.5f * n);
    cloud.normals.push_back(n);
    cloud.colors.push_back(glm::u16vec3(127.5f * (n + 1.0f)) * std::uint16_t{257});
  }
  return cloud;
}

PointCloud shuffled(const PointCloud& cloud) {
  std::vector<std::size_t> order(cloud.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  Random random(1, 0);
  for (std::size_t i = order.size(); i > 1; --i) {
    std::swap(order[i - 1], order[random.below(static_cast<std::uint32_t>(i))]);
  }
  PointCloud out;
  out.origin = cloud.origin;
  for (const std::size_t i : order) {
    out.positions.push_back(cloud.positions[i]);
    if (cloud.has_normals()) out.normals.push_back(cloud.normals[i]);
    if (cloud.has_colors()) out.colors.push_back(cloud.colors[i]);
  }
  return out;
}

std::vector<Setting> settings(int depth) {
  DracoOptions draco;
  draco.position_bits = std::max(depth, 1);
  return {{"octree",
           {OctreeOptions{Entropy::none, DepthRule::fixed(depth), kLosslessColorQuality,
                          kBestNormalQuality}}},
          {"octree zstd",
           {OctreeOptions{Entropy::zstd, DepthRule::fixed(depth), kLosslessColorQuality,
                          kBestNormalQuality}}},
          {"Draco", {draco}}};
}

double allowed_cells(const Setting& setting, int depth) {
  const double cells = std::ldexp(1.0, depth);
  if (setting.options.id() != Codec::draco) return 0.5 + 2.0 * 0x1p-24 * cells;
  return std::min(0.5 + 0x1p-20 * cells, 1.01);
}

double round_trip_cells(const PointCloud& cloud, const std::vector<glm::dvec3>& truth,
                        const DecodedFrame& decoded) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  if (!decoded.svo) return kInfinity;
  const int depth = decoded.svo->depth;
  const double cell = decoded.svo->cell_size(depth);
  const SortedPoints sorted = sort_points(cloud, decoded.cube);
  double worst = 0.0;
  std::size_t leaf = 0;
  for (std::size_t i = 0; i < sorted.points.size(); ++i) {
    const auto key = [&](std::size_t k) {
      return sorted.points[k].key >> (3 * (kMaxDepth - depth));
    };
    if (i > 0 && key(i) != key(i - 1)) ++leaf;
    if (leaf >= decoded.cloud.size()) return kInfinity;
    const glm::dvec3 off = glm::abs(decoded.cloud.world(leaf) - truth[sorted.points[i].index]);
    worst = std::max({worst, off.x / cell, off.y / cell, off.z / cell});
  }
  return leaf + 1 == decoded.cloud.size() || cloud.empty() ? worst : kInfinity;
}

std::vector<glm::dvec3> positions_of(const PointCloud& cloud) {
  std::vector<glm::dvec3> positions;
  for (std::size_t i = 0; i < cloud.size(); ++i) positions.push_back(cloud.world(i));
  return positions;
}

}  // namespace pointreel::stability
