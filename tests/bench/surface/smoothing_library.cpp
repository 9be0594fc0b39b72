#include "tests/bench/surface/smoothing_library.h"

#if POINTREEL_WITH_CGAL
#include <cstddef>
#include <utility>
#include <vector>

#include <CGAL/Simple_cartesian.h>
#include <CGAL/bilateral_smooth_point_set.h>
#include <CGAL/property_map.h>
#include <CGAL/version.h>
#endif

namespace pointreel::bench {

#if POINTREEL_WITH_CGAL

namespace {

/// As many as clean() measures noise with.
constexpr unsigned kNeighbors = 50;

}  // namespace

std::optional<std::string> smoothing_library() { return "CGAL " CGAL_VERSION_STR; }

void smooth_bilaterally(PointCloud& cloud) {
  using Kernel = CGAL::Simple_cartesian<double>;
  using Point = std::pair<Kernel::Point_3, Kernel::Vector_3>;
  std::vector<Point> points;
  points.reserve(cloud.size());
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const glm::vec3 &p = cloud.positions[i], &n = cloud.normals[i];
    points.emplace_back(Kernel::Point_3(p.x, p.y, p.z), Kernel::Vector_3(n.x, n.y, n.z));
  }
  CGAL::bilateral_smooth_point_set<CGAL::Sequential_tag>(
      points, kNeighbors,
      CGAL::parameters::point_map(CGAL::First_of_pair_property_map<Point>())
          .normal_map(CGAL::Second_of_pair_property_map<Point>()));
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const auto& [p, n] = points[i];
    const glm::dvec3 normal(n.x(), n.y(), n.z());
    const double length = glm::length(normal);
    cloud.positions[i] = glm::vec3(glm::dvec3(p.x(), p.y(), p.z()));
    if (length > 0.0) cloud.normals[i] = glm::vec3(normal / length);
  }
}

#else

std::optional<std::string> smoothing_library() { return std::nullopt; }
void smooth_bilaterally(PointCloud&) {}

#endif

}  // namespace pointreel::bench
