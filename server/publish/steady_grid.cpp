#include <algorithm>

#include "common/base/try.h"
#include "server/publish/publisher.h"

namespace pointreel {
namespace {

/// The margin on each side, relative to the box.
constexpr double kMargin = 0.1;
/// The largest edge of the cube, relative to what the box of one frame needs.
constexpr double kMaxGrowth = 2.0;

Box with_margin(const Box& box) {
  if (box.empty()) return box;
  const glm::dvec3 margin = kMargin * box.extent();
  return {box.min - margin, box.max + margin};
}

double longest_edge(const Box& box) {
  const glm::dvec3 extent = box.extent();
  return std::max({extent.x, extent.y, extent.z});
}

bool contains(const Box& outer, const Box& inner) {
  return inner.empty() || (!outer.empty() && glm::all(glm::lessThanEqual(outer.min, inner.min)) &&
                           glm::all(glm::greaterThanEqual(outer.max, inner.max)));
}

}  // namespace

Result<Grid> SteadyGrid::of(const Box& box) {
  if (grid_ && contains({grid_->cube.origin, grid_->cube.origin + grid_->cube.edge}, box)) {
    return *grid_;
  }
  Box roomy = with_margin(box);
  // Whatever moves around will return to where it was.
  Box both = roomy;
  both.grow(held_);
  if (longest_edge(both) <= kMaxGrowth * longest_edge(roomy)) roomy = both;
  grid_ = TRY(grid_for(roomy, options_));
  held_ = roomy;
  return *grid_;
}

}  // namespace pointreel
