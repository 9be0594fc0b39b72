#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <glm/glm.hpp>

#include "pointreel/cloud.h"

namespace pointreel {

/// The distinct positions of a cloud, in an order that depends on their set alone and in which
/// neighbours stand close together: what searches ask for and search in.
struct DistinctPoints {
  std::vector<glm::dvec3> positions;   ///< relative to the cube's origin
  std::vector<std::uint32_t> begin;    ///< one more than positions
  std::vector<std::uint32_t> members;  ///< the cloud's points at i: members[begin[i], begin[i + 1])

  std::size_t size() const { return positions.size(); }
  std::span<const std::uint32_t> at(std::size_t i) const {
    return {members.data() + begin[i], begin[i + 1] - begin[i]};
  }
};

/// `cube` holds the cloud; the same cube for two clouds that are compared.
DistinctPoints distinct_points(const PointCloud& cloud, const Cube& cube);

/// For each query the points that are nearest to it: commonly one, several where it lies between.
struct NearestPoints {
  std::vector<double> squared_distances;  ///< to the nearest, exact
  std::vector<std::uint32_t> begin;       ///< one more than queries
  std::vector<std::uint32_t> points;

  std::span<const std::uint32_t> of(std::size_t query) const {
    return {points.data() + begin[query], begin[query + 1] - begin[query]};
  }
};

/// How many points may be equally near: the first ones that the search comes to.
inline constexpr std::size_t kMaxEquallyNear = 64;

/// The nearest of `points` (not empty) to each query, and all others whose distance is no more than
/// `tolerance` larger, in ascending order of their number. Exact: a k-d tree. The same whatever the
/// number of threads (TBB's, of the caller's arena). O((n + m) log m).
NearestPoints nearest_points(std::span<const glm::dvec3> queries,
                             std::span<const glm::dvec3> points, double tolerance);

}  // namespace pointreel
