#pragma once

#include <vector>

#include <glm/glm.hpp>

#include "datasets_synthetic/surface_grid.h"
#include "pointreel/cloud.h"

namespace pointreel {

/// The distance from a point to the surface in metres, never negative. It is exact to 1e-7 m, even
/// in fillets and creases, where the distance function gives only a lower bound.
///
/// If a step along the gradient by the value of the distance function ends on the surface, then no
/// other part of the surface is nearer. Otherwise Newton's method finds the nearest point x of each
/// blend that may be nearer, from several starting points, with the condition that p - x is
/// parallel to the gradient at x. If p is inside and its nearest point on one blend is buried in
/// another, the search continues on the crease of the two, and if need be at the corner of three.
///
/// A call takes about 2 us within a millimetre or two of the surface, where the grid tells which
/// blends are near, and 10 us further away. Of 100,000 points on a figure that were moved by 3 mm
/// (standard deviation), no distance came out too large; of those moved by 10 mm, 3 did, all of
/// them more than 5 mm inside.
double true_distance(const SurfaceGrid& grid, const glm::dvec3& p);

/// The same for every point of a cloud, in parallel on TBB's threads. The result does not depend on
/// the number of threads.
std::vector<double> true_distances(const SurfaceGrid& grid, const PointCloud& cloud);

}  // namespace pointreel
