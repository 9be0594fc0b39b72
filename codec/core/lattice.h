#pragma once

#include <optional>

#include "pointreel/cloud.h"
#include "pointreel/geometry.h"

namespace pointreel {

/// A regular grid on which points lie: `point` plus multiples of `step` along each axis.
struct PointLattice {
  glm::dvec3 point{0.0};
  double step = 1.0;
};

/// The lattice of a voxelised cloud: the coarsest on which all of its points lie, up to the
/// rounding of their floats. Steps are 1, 2 or 5 times a power of ten from 0.0001 to 1000, which
/// includes the whole numbers of most voxelised captures and the millimetres of depth cameras; or,
/// of many points, any other, as after scaling. The lattice contains zero, unless the points are
/// shifted against it, like cells that are given by their centres.
///
/// Nothing for other clouds, where it takes only a few points to decide; O(n) otherwise.
std::optional<PointLattice> lattice_of(const PointCloud& cloud);

/// A lattice that contains both, if one of them does.
std::optional<PointLattice> common_lattice(const PointLattice& a, const PointLattice& b);

/// The cube that holds `box` and whose cells at the returned depth are centred on the lattice and
/// as large as its step: points of the lattice decode to themselves.
VoxelCube lattice_cube(const Box& box, const PointLattice& lattice);

}  // namespace pointreel
