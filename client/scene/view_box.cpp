#include "client/scene/view_box.h"

#include <algorithm>

namespace pointreel {
namespace {

/// A frame that is so much smaller than the bounds cannot be seen in a picture of those.
constexpr double kSpeck = 30.0;
/// A view of the bounds is no view of the frame if a few of its own points make them so much
/// larger.
constexpr double kStray = 2.0;
/// How close to a side of the bounds a frame's box reaches that side, as a share of the bounds.
/// That is more than a cell of a base layer.
constexpr double kReaches = 0.05;

double extent(const Box& box) { return glm::length(box.extent()); }

/// The bounds without what only a few points of this frame add to them.
Box without_strays(const Box& bounds, const FrameBoxes& frame) {
  Box box = bounds;
  for (int axis = 0; axis < 3; ++axis) {
    const double close = kReaches * bounds.extent()[axis];
    if (frame.all.min[axis] <= bounds.min[axis] + close)
      box.min[axis] = std::max(bounds.min[axis], frame.main.min[axis]);
    if (frame.all.max[axis] >= bounds.max[axis] - close)
      box.max[axis] = std::min(bounds.max[axis], frame.main.max[axis]);
  }
  return box;
}

}  // namespace

Box view_box(const Box& bounds, const FrameBoxes& first) {
  if (first.main.empty() || bounds.empty()) return bounds;
  const Box box = without_strays(bounds, first);
  if (extent(bounds) > kStray * extent(box)) return box;
  return extent(bounds) > kSpeck * extent(first.main) ? first.main : bounds;
}

}  // namespace pointreel
