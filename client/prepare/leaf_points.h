#pragma once

#include <span>
#include <vector>

#include <glm/glm.hpp>
#include <glm/gtc/type_precision.hpp>

#include "codec/core/build.h"
#include "pointreel/cloud.h"
#include "pointreel/octree.h"

namespace pointreel {

// What the leaves of a tree keep of the points that it was built from, besides the means of their
// attributes: where the points lie, and how large they are. Results are in the order of the leaves.

/// From the centre of each leaf along its normal to the mean of its points, as leaf_heights
/// estimates it from the leaves alone. Faster, but noise stays. At most half the extent of the cell
/// along the normal. `normals`: of the leaves, of length 32767, or zero where unknown.
std::vector<float> point_heights(const Svo& svo, const PointCloud& cloud,
                                 const SortedPoints& sorted, std::span<const glm::i16vec3> normals);

/// Radii for leaves from those of the points, which the cloud has: the root of the mean square in
/// each, and at least half a leaf's diagonal, as for leaf_radii. To add up the areas of the points
/// instead makes outlines too thick, since points along curves overlap more than others do.
std::vector<float> own_radii(const Svo& svo, const PointCloud& cloud, const SortedPoints& sorted);

}  // namespace pointreel
