#include "common/surface/distance.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <nanoflann.hpp>

namespace pointreel {
namespace {

using Points = std::vector<glm::dvec3>;

Points relative_to(const glm::dvec3& origin, const PointCloud& cloud) {
  Points points(cloud.size());
  const glm::dvec3 offset = cloud.origin - origin;
  for (std::size_t i = 0; i < points.size(); ++i) {
    points[i] = glm::dvec3(cloud.positions[i]) + offset;
  }
  return points;
}

/// What nanoflann asks of a set of points.
struct PointSet {
  const Points& points;

  std::size_t kdtree_get_point_count() const { return points.size(); }
  double kdtree_get_pt(std::size_t i, std::size_t axis) const {
    return points[i][static_cast<glm::length_t>(axis)];
  }
  template <class BoundingBox>
  bool kdtree_get_bbox(BoundingBox&) const {
    return false;
  }
};

OneWayDistance one_way(const Points& from, const Points& to) {
  using Tree = nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<double, PointSet>,
                                                   PointSet, 3, std::uint32_t>;
  const PointSet set{to};
  Tree tree(3, set, nanoflann::KDTreeSingleIndexAdaptorParams(10));
  OneWayDistance result;
  for (const glm::dvec3& p : from) {
    std::uint32_t nearest = 0;
    double squared = 0.0;
    tree.knnSearch(&p.x, 1, &nearest, &squared);
    result.mean_squared += squared;
    result.max = std::max(result.max, squared);
  }
  result.mean_squared /= static_cast<double>(from.size());
  result.max = std::sqrt(result.max);
  return result;
}

}  // namespace

double CloudDistance::d1() const { return std::max(a_to_b.mean_squared, b_to_a.mean_squared); }

double CloudDistance::max() const { return std::max(a_to_b.max, b_to_a.max); }

double d1_psnr(double d1, double peak) { return 10.0 * std::log10(3.0 * peak * peak / d1); }

Result<CloudDistance> cloud_distance(const PointCloud& a, const PointCloud& b) {
  if (a.empty() || b.empty()) return fail("a cloud without points has no distance to another");
  // The clouds may have different origins, both far from zero.
  const Points in_a = relative_to(a.origin, a), in_b = relative_to(a.origin, b);
  return CloudDistance{one_way(in_a, in_b), one_way(in_b, in_a)};
}

}  // namespace pointreel
