#pragma once

#include "pointreel/cloud.h"
#include "pointreel/geometry.h"

namespace pointreel {

/// A bound on the distance between a point and its decoded position, in the units of the cube, for
/// all points inside the cube. (The encoder moves points outside it to its faces.) Conversely, each
/// decoded position is no farther from the nearest point.
///
/// `depth`: the level of the leaves that are decoded, which is coarser for a prefix of the layers,
/// or Draco's position bits.
///
/// The bound is half the diagonal of a cell, plus the rounding errors on each axis. Decoded
/// coordinates are floats relative to the cube's corner, which are off by up to 2^-24 of its edge.
/// Doubles are off by up to 2^-53 of the cube's largest coordinate, which matters far from zero.
/// The cloud's own origin is assumed to be no farther away than that.
double max_geometry_error(const Cube& cube, int depth);

/// The same bound for the points of one cloud, found by comparing each of them with its decoded
/// position: 0 if all of them decode to themselves, and never more than max_geometry_error for
/// points inside the cube. O(n).
double geometry_error(const PointCloud& cloud, const Cube& cube, int depth);

}  // namespace pointreel
