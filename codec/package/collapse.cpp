#include "codec/package/collapse.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <tuple>
#include <vector>

#include <fmt/format.h>

#include "codec/package/strays.h"

namespace pointreel {
namespace {

/// A cube that is this much larger than that of the frame alone shows that other frames are far
/// away.
constexpr double kFarApart = 16.0;
/// Whatever is fewer voxels long is not recognised.
constexpr double kFewestVoxels = 16.0;

std::vector<glm::vec3> distinct_points(const PointCloud& cloud) {
  const auto before = [](const glm::vec3& a, const glm::vec3& b) {
    return std::tie(a.x, a.y, a.z) < std::tie(b.x, b.y, b.z);
  };
  std::vector<glm::vec3> points = cloud.positions;
  std::sort(points.begin(), points.end(), before);
  points.erase(std::unique(points.begin(), points.end()), points.end());
  return points;
}

/// The longest side of the box around the middle half of the points on each axis, which a few far
/// points do not change.
double length_of_middle(std::vector<glm::vec3> points) {
  const std::size_t quarter = points.size() / 4;
  double length = 0.0;
  for (int axis = 0; axis < 3; ++axis) {
    const auto before = [axis](const glm::vec3& a, const glm::vec3& b) {
      return a[axis] < b[axis];
    };
    const auto low = points.begin() + static_cast<std::ptrdiff_t>(quarter);
    const auto high = points.end() - 1 - static_cast<std::ptrdiff_t>(quarter);
    std::nth_element(points.begin(), high, points.end(), before);
    const double to = (*high)[axis];
    std::nth_element(points.begin(), low, points.end(), before);
    length = std::max(length, to - (*low)[axis]);
  }
  return length;
}

/// Whether the octree cannot keep the points apart because its cells are too large. Points that
/// nearly coincide, such as repeated vertices after a rounding, are no reason.
bool misses_delta(const EncodedFrame& encoded, const PointCloud& cloud, const Grid& grid,
                  const DepthRule& rule) {
  if (rule.most < kMaxDepth) return false;
  const auto enough = [&](std::size_t points) {
    return 2.0 * encoded.coded_points >= (1.0 - rule.delta) * static_cast<double>(points);
  };
  if (enough(cloud.size())) return false;
  const std::vector<glm::vec3> points = distinct_points(cloud);
  return !enough(points.size()) &&
         length_of_middle(points) < std::ldexp(kFewestVoxels * grid.cube.edge, -encoded.depth);
}

}  // namespace

std::optional<Collapse> collapse_of(const EncodedFrame& encoded, const PointCloud& cloud,
                                    const Grid& grid, const EncodeOptions& used, bool strays) {
  // The strays may be those of other frames.
  if (cloud.empty()) return std::nullopt;
  const glm::dvec3 extent = bounds(cloud).extent();
  const double length =
      strays ? 2.0 * length_of_middle(cloud.positions) : std::max({extent.x, extent.y, extent.z});
  if (!(length > 0.0)) return std::nullopt;
  const bool far_apart = grid.cube.edge > kFarApart * length;
  const auto* octree = std::get_if<OctreeOptions>(&used.codec);
  if (octree != nullptr && octree->depth.kind == DepthRule::Kind::delta) {
    if (!misses_delta(encoded, cloud, grid, octree->depth)) return std::nullopt;
  } else {
    const auto* asked = std::get_if<OctreeOptions>(&grid.encode.codec);
    const int depth = asked != nullptr ? asked->depth.depth
                                       : std::get<DracoOptions>(grid.encode.codec).position_bits;
    const double voxels = std::ldexp(length / grid.cube.edge, depth);
    if (!far_apart || voxels >= kFewestVoxels || distinct_points(cloud).size() == 1)
      return std::nullopt;
  }
  return Collapse{fmt::format("its {} points collapse into voxels of {:.3g}", cloud.size(),
                              std::ldexp(grid.cube.edge, -encoded.depth)),
                  far_apart
                      ? "the frames of its segment lie too far apart for one cube"
                      : fmt::format("some lie too far away for an octree of {} levels, such as {}",
                                    kMaxDepth, farthest_text(cloud)),
                  far_apart};
}

Result<void> check_collapse(const EncodedFrame& encoded, const PointCloud& cloud, const Grid& grid,
                            bool strays) {
  const auto collapse = collapse_of(encoded, cloud, grid, grid.encode, strays);
  if (!collapse) return {};
  if (strays) return fail(ErrorCode::limit, collapse->what);
  return fail(ErrorCode::limit, fmt::format("{}, because {}: {}", collapse->what, collapse->why,
                                            collapse->far_apart ? "let fewer frames share a segment"
                                                                : "remove these"));
}

}  // namespace pointreel
