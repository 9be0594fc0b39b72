#include "client/prepare/main_box.h"

#include <algorithm>
#include <cstddef>
#include <vector>

#include "common/base/spread.h"
#include "common/octree/build.h"
#include "pointreel/geometry.h"

namespace pointreel {
namespace {

constexpr std::size_t kSamples = 4096, kOutermost = 200;
constexpr double kMargin = 0.05;

}  // namespace

Box main_box(const PointCloud& cloud) {
  if (cloud.empty()) return {};
  const std::size_t count = std::min(kSamples, cloud.size()), outer = count / kOutermost;
  Box box{cloud.origin, cloud.origin};
  std::vector<double> places(count);
  for (int axis = 0; axis < 3; ++axis) {
    for (std::size_t i = 0; i < count; ++i)
      places[i] = cloud.positions[spread_index(i, count, cloud.size())][axis];
    const auto place = [&](std::size_t rank) {
      const auto at = places.begin() + static_cast<std::ptrdiff_t>(rank);
      std::nth_element(places.begin(), at, places.end());
      return *at;
    };
    const double low = place(outer), high = place(count - 1 - outer);
    box.min[axis] += low - kMargin * (high - low);
    box.max[axis] += high + kMargin * (high - low);
  }
  return box.min == box.max ? Box{} : box;
}

Box main_box(const Svo& svo) {
  int level = 0;
  while (level < svo.depth && svo.node_count(level) < kSamples) ++level;
  const PointCloud centers = leaf_centers(level < svo.depth ? truncate(svo, level) : svo);
  if (centers.empty()) return {};
  Box box = main_box(centers);
  if (box.empty()) box = bounds(centers);
  const double half = 0.5 * svo.cube.edge / static_cast<double>(1u << level);
  box.min -= half;
  box.max += half;
  return box;
}

}  // namespace pointreel
