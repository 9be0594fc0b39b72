#pragma once

#include <cstdint>
#include <vector>

#include "pointreel/octree.h"

namespace pointreel {

/// Two leaves of an octree in neighbouring cells.
struct LeafPair {
  std::uint32_t first, second;  ///< numbers among the leaves; first < second
  std::uint8_t place;  ///< of the second in the 3 x 3 x 3 block around the first, x fastest
};

/// All pairs of leaves whose cells touch, even in a corner only. Each is there once, in the order
/// of the first. O(nodes): the pairs of a level follow from those of the level above.
std::vector<LeafPair> leaf_pairs(const Svo& svo);

}  // namespace pointreel
