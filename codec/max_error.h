#pragma once

#include "pointreel/geometry.h"

namespace pointreel {

/// How far a point can at most be from where it decodes to, in units of the cube: what an encoder
/// promises of any cloud whose points lie in the cube (those outside move to its faces first).
/// Nothing decodes to a place that is farther from all points, either.
///
/// `depth`: of the octree's leaves as they are decoded (a prefix of the layers ends at a coarser
/// level), or Draco's position bits.
///
/// Half a cell's diagonal, and on each axis what rounding adds: decoded coordinates are floats
/// relative to the cube's corner, 2^-24 of its edge off; and doubles tell apart 2^-53 of the cube's
/// farthest coordinate, which counts far from zero. The cloud's own origin is taken to be no
/// farther away than that.
double max_geometry_error(const Cube& cube, int depth);

}  // namespace pointreel
