#include "client/prepare/main_box.h"

#include <algorithm>
#include <cstddef>
#include <vector>

#include "codec/core/build.h"
#include "common/base/spread.h"
#include "pointreel/geometry.h"

namespace pointreel {
namespace {

constexpr std::size_t kSamples = 4096, kOutermost = 200;
constexpr std::size_t kFewest = 3;  ///< of which one can be left out
constexpr double kMargin = 0.05;

/// Without `outer` of some thousand samples on each side.
Box inner_box(const PointCloud& cloud, std::size_t outer) {
  const std::size_t count = std::min(kSamples, cloud.size());
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

}  // namespace

FrameBoxes frame_boxes(const PointCloud& cloud) {
  FrameBoxes boxes;
  boxes.rough = false;
  if (cloud.empty()) return boxes;
  boxes.all = bounds(cloud);
  boxes.main = inner_box(cloud, std::min(kSamples, cloud.size()) / kOutermost);
  return boxes;
}

FrameBoxes frame_boxes(const Svo& svo, std::uint32_t points, bool whole) {
  int level = 0;
  while (level < svo.depth && svo.node_count(level) < kSamples) ++level;
  const PointCloud centers = leaf_centers(level < svo.depth ? truncate(svo, level) : svo);
  FrameBoxes boxes;
  boxes.rough = !whole && centers.size() < kSamples;
  if (centers.empty()) return boxes;
  std::size_t outer = std::min(kSamples, centers.size()) / kOutermost;
  if (points >= kOutermost && centers.size() >= kFewest) outer = std::max<std::size_t>(outer, 1);
  boxes.all = bounds(centers);
  boxes.main = inner_box(centers, outer);
  if (boxes.main.empty()) boxes.main = boxes.all;
  const double half = 0.5 * svo.cube.edge / static_cast<double>(1u << level);
  for (Box* box : {&boxes.all, &boxes.main}) {
    box->min -= half;
    box->max += half;
  }
  return boxes;
}

}  // namespace pointreel
