#pragma once

#include <vector>

#include "pointreel/executor.h"
#include "pointreel/octree.h"

namespace pointreel {

/// Radii of the surfels that stand for the nodes of a tree, in the order of the nodes. They are
/// computed from those of the leaves, in the order of the leaves.
///
/// A surfel of radius r stands for a piece of the surface of area r^2 (tree_radii.h), so that a
/// node's surfel stands for the sum of its children's areas: a coarser cut covers as much of the
/// picture as a finer one. Where noise has thickened the surface that would be too much. A node
/// therefore gets no more than a disc around its cell or, where leaves lie farther apart than their
/// size, twice the area of its largest child. The threads of the executor share large levels.
std::vector<float> node_radii(const Svo& svo, const std::vector<float>& leaf_radii,
                              const Executor& executor = {});

}  // namespace pointreel
