#pragma once

#include <vector>

#include "common/octree/svo.h"

namespace pointreel {

/// Radii of the surfels that stand for the nodes of a tree, from those of its leaves, in their
/// order: the nodes' in theirs.
///
/// A surfel of radius r stands for a piece of the surface of area r^2 (tree_radii.h), so a node's
/// stands for the sum of its children's: a coarser cut covers as much of the picture as a finer
/// one. But for no more than its cell can show (a disc around it), where noise has thickened the
/// surface, unless one of its children is that large: where leaves lie farther apart than their
/// size, the next ones are merged along the curves that they lie on, while radii close the gaps
/// between curves. Then it gets at most sqrt(2) of its largest child's area: half of the growth
/// that area asks for.
std::vector<float> node_radii(const Svo& svo, const std::vector<float>& leaf_radii);

}  // namespace pointreel
