#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "pointreel/octree.h"

namespace pointreel {

inline constexpr std::uint32_t kNoNode = ~std::uint32_t{0};

/// The 27 nodes of one level in the 3 x 3 x 3 block around a node, x fastest, itself in the middle
/// (number 13); kNoNode where nothing is.
using NodeBlock = std::array<std::uint32_t, 27>;

/// The block of every node of the tree. Blocks of children follow from those of their parents, so
/// nothing is searched. O(nodes).
std::vector<NodeBlock> node_blocks(const Svo& svo);

}  // namespace pointreel
