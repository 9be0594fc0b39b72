#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <glm/glm.hpp>

#include "pointreel/cloud.h"

namespace pointreel {

/// The distinct positions of a cloud, in an order that depends only on their set, and in which
/// neighbours are close to each other, which makes searches fast.
struct DistinctPoints {
  std::vector<glm::dvec3> positions;   ///< relative to the cube's origin
  std::vector<std::uint32_t> begin;    ///< has one entry more than `positions`
  std::vector<std::uint32_t> members;  ///< the cloud's points at i: members[begin[i], begin[i + 1])

  std::size_t size() const { return positions.size(); }
  std::span<const std::uint32_t> at(std::size_t i) const {
    return {members.data() + begin[i], begin[i + 1] - begin[i]};
  }
};

/// `cube` contains the cloud. Two clouds that are compared need the same cube.
DistinctPoints distinct_points(const PointCloud& cloud, const Cube& cube);

/// For each query, the points that are nearest to it. There are several if they are equally near.
struct NearestPoints {
  std::vector<double> squared_distances;  ///< to the nearest, exact
  std::vector<std::uint32_t> begin;       ///< has one entry more than there are queries
  std::vector<std::uint32_t> points;

  std::span<const std::uint32_t> of(std::size_t query) const {
    return {points.data() + begin[query], begin[query + 1] - begin[query]};
  }
};

/// At most this many equally near points are returned: the first that the search finds.
inline constexpr std::size_t kMaxEquallyNear = 64;

/// The nearest of `points` (at least one) to each query, and all points whose distance is larger by
/// no more than `tolerance`, in ascending order of their indices. The search is exact; it uses a
/// k-d tree and the threads of the caller's TBB arena, on whose number the result does not depend.
/// O((n + m) log m).
NearestPoints nearest_points(std::span<const glm::dvec3> queries,
                             std::span<const glm::dvec3> points, double tolerance);

}  // namespace pointreel
