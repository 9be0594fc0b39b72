#include "server/pack/collapse.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

#include <fmt/format.h>

namespace pointreel {
namespace {

/// A cube that is this much larger than that of the frame alone shows that other frames are far
/// away.
constexpr double kFarApart = 16.0;
/// Whatever is fewer voxels long is not recognised.
constexpr double kFewestVoxels = 16.0;

std::size_t distinct_points(const PointCloud& cloud) {
  std::vector<std::array<float, 3>> points;
  points.reserve(cloud.size());
  for (const glm::vec3& p : cloud.positions) points.push_back({p.x, p.y, p.z});
  std::sort(points.begin(), points.end());
  return static_cast<std::size_t>(std::unique(points.begin(), points.end()) - points.begin());
}

/// Whether the octree is too shallow for its delta although nothing but kMaxDepth bounds it.
bool misses_delta(const EncodedFrame& encoded, const PointCloud& cloud, const DepthRule& rule) {
  if (rule.most < kMaxDepth) return false;
  const double voxels = 2.0 * encoded.coded_points;
  const auto enough = [&](std::size_t points) {
    return voxels >= (1.0 - rule.delta) * static_cast<double>(points);
  };
  return !enough(cloud.size()) && !enough(distinct_points(cloud));
}

}  // namespace

std::optional<std::string> collapse_of(const EncodedFrame& encoded, const PointCloud& cloud,
                                       const Grid& grid, const EncodeOptions& used) {
  const glm::dvec3 extent = bounds(cloud).extent();
  const double length = std::max({extent.x, extent.y, extent.z});
  if (!(length > 0.0)) return std::nullopt;
  const bool far_apart = grid.cube.edge > kFarApart * length;
  const auto* octree = std::get_if<OctreeOptions>(&used.codec);
  if (octree != nullptr && octree->depth.kind == DepthRule::Kind::delta) {
    if (!misses_delta(encoded, cloud, octree->depth)) return std::nullopt;
  } else {
    const auto* asked = std::get_if<OctreeOptions>(&grid.encode.codec);
    const int depth = asked != nullptr ? asked->depth.depth
                                       : std::get<DracoOptions>(grid.encode.codec).position_bits;
    const double voxels = std::ldexp(length / grid.cube.edge, depth);
    if (!far_apart || voxels >= kFewestVoxels || distinct_points(cloud) == 1) return std::nullopt;
  }
  return fmt::format(
      "its {} points collapse into voxels of {:.3g}, because {}", cloud.size(),
      std::ldexp(grid.cube.edge, -encoded.depth),
      far_apart ? "the frames of its segment lie too far apart for one cube: give --cube frame"
                : fmt::format("some lie too far away for an octree of {} levels: remove these",
                              kMaxDepth));
}

}  // namespace pointreel
