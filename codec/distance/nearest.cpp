#include "codec/distance/nearest.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

#include <nanoflann.hpp>
#include <tbb/parallel_for.h>

#include "codec/core/build.h"
#include "pointreel/octree.h"

namespace pointreel {
namespace {

constexpr std::size_t kLeafSize = 10;
constexpr std::size_t kBlock = 4096;  // queries of a task

/// The interface that nanoflann requires of a set of points.
struct PointSet {
  std::span<const glm::dvec3> points;

  std::size_t kdtree_get_point_count() const { return points.size(); }
  double kdtree_get_pt(std::size_t i, std::size_t axis) const {
    return points[i][static_cast<glm::length_t>(axis)];
  }
  template <class BoundingBox>
  bool kdtree_get_bbox(BoundingBox&) const {
    return false;
  }
};
using Tree = nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<double, PointSet>,
                                                 PointSet, 3, std::uint32_t>;

/// nanoflann reports points to this. It keeps those that are as near as the nearest one.
class Nearest {
 public:
  using DistanceType = double;

  explicit Nearest(double tolerance) : tolerance_(tolerance) {}

  void clear() {
    best_ = limit_ = std::numeric_limits<double>::infinity();
    found_.clear();
  }

  bool addPoint(double squared, std::uint32_t point) {
    // nanoflann reads the limit only once for each leaf, so points beyond it are reported too.
    if (!(squared < limit_)) return true;
    if (squared < best_) {
      best_ = squared;
      const double reach = std::sqrt(squared) + tolerance_;
      // Slightly larger, because nanoflann skips points exactly at the limit, and rounds distances
      // to branches.
      limit_ = std::max(reach * reach, squared) * (1.0 + 1e-12) +
               std::numeric_limits<double>::denorm_min();
      std::erase_if(found_, [this](const Found& f) { return f.squared >= limit_; });
      if (found_.size() == kMaxEquallyNear) found_.pop_back();
    }
    if (found_.size() < kMaxEquallyNear) found_.push_back({squared, point});
    return true;
  }
  double worstDist() const { return limit_; }
  bool full() const { return true; }

  double squared_distance() const { return best_; }

  /// Appends the points in ascending order.
  void append_to(std::vector<std::uint32_t>& points) {
    const std::size_t before = points.size();
    for (const Found& f : found_) points.push_back(f.point);
    std::sort(points.begin() + static_cast<std::ptrdiff_t>(before), points.end());
  }

 private:
  struct Found {
    double squared;
    std::uint32_t point;
  };
  double tolerance_;
  double best_ = 0.0, limit_ = 0.0;
  std::vector<Found> found_;
};

}  // namespace

DistinctPoints distinct_points(const PointCloud& cloud, const Cube& cube) {
  std::vector<KeyIndex> sorted = sort_points(cloud, cube).points;
  const auto less = [&cloud](const KeyIndex& a, const KeyIndex& b) {
    const glm::vec3 &p = cloud.positions[a.index], &q = cloud.positions[b.index];
    return std::tie(p.x, p.y, p.z, a.index) < std::tie(q.x, q.y, q.z, b.index);
  };
  for (auto run = sorted.begin(); run != sorted.end();) {
    const auto end = std::find_if(run, sorted.end(),
                                  [&run](const KeyIndex& point) { return point.key != run->key; });
    if (end - run > 1) std::sort(run, end, less);
    run = end;
  }
  DistinctPoints distinct;
  distinct.positions.reserve(sorted.size());
  distinct.begin.reserve(sorted.size() + 1);
  distinct.members.reserve(sorted.size());
  const glm::dvec3 offset = cloud.origin - cube.origin;
  for (std::size_t i = 0; i < sorted.size(); ++i) {
    const glm::vec3& p = cloud.positions[sorted[i].index];
    if (i == 0 || p != cloud.positions[sorted[i - 1].index]) {
      distinct.begin.push_back(static_cast<std::uint32_t>(i));
      distinct.positions.push_back(offset + glm::dvec3(p));
    }
    distinct.members.push_back(sorted[i].index);
  }
  distinct.begin.push_back(static_cast<std::uint32_t>(sorted.size()));
  return distinct;
}

NearestPoints nearest_points(std::span<const glm::dvec3> queries,
                             std::span<const glm::dvec3> points, double tolerance) {
  const PointSet set{points};
  const Tree tree(3, set, nanoflann::KDTreeSingleIndexAdaptorParams(kLeafSize));
  NearestPoints result;
  result.squared_distances.resize(queries.size());
  result.begin.resize(queries.size() + 1);
  const std::size_t blocks = (queries.size() + kBlock - 1) / kBlock;
  std::vector<std::vector<std::uint32_t>> found(blocks);
  tbb::parallel_for(std::size_t{0}, blocks, [&](std::size_t block) {
    Nearest nearest(tolerance);
    const std::size_t end = std::min(queries.size(), (block + 1) * kBlock);
    found[block].reserve(kBlock + kBlock / 8);
    for (std::size_t i = block * kBlock; i < end; ++i) {
      nearest.clear();
      tree.findNeighbors(nearest, &queries[i].x, nanoflann::SearchParams());
      result.squared_distances[i] = nearest.squared_distance();
      result.begin[i] = static_cast<std::uint32_t>(found[block].size());
      nearest.append_to(found[block]);
    }
  });
  for (std::size_t block = 0; block < blocks; ++block) {
    const auto before = static_cast<std::uint32_t>(result.points.size());
    const std::size_t end = std::min(queries.size(), (block + 1) * kBlock);
    for (std::size_t i = block * kBlock; i < end; ++i) result.begin[i] += before;
    result.points.insert(result.points.end(), found[block].begin(), found[block].end());
  }
  result.begin.back() = static_cast<std::uint32_t>(result.points.size());
  return result;
}

}  // namespace pointreel
