#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "pointreel/octree.h"

namespace pointreel {

inline constexpr std::uint32_t kNoNode = ~std::uint32_t{0};

/// The 27 nodes of a level in the 3 x 3 x 3 block around a node, x fastest, with the node itself in
/// the middle (index 13); kNoNode where there is no node.
using NodeBlock = std::array<std::uint32_t, 27>;

/// The blocks around the children of an internal node, in their order, derived from the block
/// around the node itself. `blocks` has room for its children, of which there are at most eight.
void child_blocks(const Svo& svo, const NodeBlock& around, NodeBlock* blocks);

/// The block around every node of the tree. The blocks of children are derived from those of their
/// parents, without any search. O(nodes).
std::vector<NodeBlock> node_blocks(const Svo& svo);

}  // namespace pointreel
