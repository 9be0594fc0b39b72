#include "codec/package/steady_grid.h"

#include <algorithm>

#include "common/base/try.h"

namespace pointreel {
namespace {

/// The margin on each side, relative to the box.
constexpr double kMargin = 0.1;
/// The largest edge of the cube, relative to what the box of one frame needs.
constexpr double kMaxGrowth = 2.0;
/// A cube that is larger than this is made anew.
constexpr double kMaxRoom = 8.0;
/// The cells of cleaned frames stay until those that fit a frame differ by this factor.
constexpr double kSameCells = 1.25;

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

bool same(const PointLattice& a, const PointLattice& b) {
  return a.point == b.point && a.step == b.step;
}

bool nearly_same(const PointLattice& a, const PointLattice& b) {
  return a.point == b.point && a.step < kSameCells * b.step && b.step < kSameCells * a.step;
}

}  // namespace

Result<Grid> SteadyGrid::of(const PointCloud& cloud, const Box& box, const CleanReport& cleaning) {
  if (grid_ && box.empty()) return *grid_;
  const bool by_points = cleaning.cleaned && cells_follow_points(options_);
  std::optional<PointLattice> lattice;
  if (by_points) {
    lattice = lattice_for_cells(cleaning.cell);
  } else {
    lattice = lattice_of(cloud);
  }
  // Together with the frames before, if their cells are still fine enough.
  if (by_points && lattice_ && nearly_same(*lattice, *lattice_)) {
    lattice = lattice_;
  } else if (lattice && lattice_) {
    if (const auto both = common_lattice(*lattice_, *lattice)) lattice = both;
  }
  const bool fits_cells = on_lattice_ ? lattice && same(*lattice, *lattice_)
                                      : !lattice || (lattice_ && same(*lattice, *lattice_));
  // A single frame with a point far away would make all later ones collapse.
  const double edge = longest_edge(box);
  bool too_large = false;
  if (grid_ && edge > 0.0 && grid_->cube.edge > kMaxRoom * edge) {
    const Result<Grid> own = grid_for(with_margin(box), options_, lattice);
    too_large = own && grid_->cube.edge > kMaxRoom * own->cube.edge;
  }
  if (grid_ && fits_cells && !too_large &&
      contains({grid_->cube.origin, grid_->cube.origin + grid_->cube.edge}, box)) {
    return *grid_;
  }
  Box roomy = with_margin(box);
  // Whatever moves around will return to where it was.
  Box both = roomy;
  both.grow(held_);
  if (longest_edge(both) <= kMaxGrowth * longest_edge(roomy)) roomy = both;
  on_lattice_ =
      lattice && (by_points || options_.voxel || reaches(*lattice, roomy, cloud, options_.encode));
  grid_ = TRY(grid_for(roomy, options_, on_lattice_ ? lattice : std::nullopt));
  held_ = roomy;
  lattice_ = lattice;
  return *grid_;
}

}  // namespace pointreel
