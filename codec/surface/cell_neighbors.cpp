#include "codec/surface/cell_neighbors.h"

#include <bit>

namespace pointreel {
namespace {

/// Where to find a neighbour of a child: the node in the parent's block that contains it, and its
/// octant in that node. There is one for each octant of the child and each of the 27 offsets.
struct Step {
  std::uint8_t parent;
  std::uint8_t octant;
};
using Steps = std::array<std::array<Step, 27>, 8>;

constexpr Steps make_steps() {
  Steps steps{};
  for (unsigned octant = 0; octant < 8; ++octant) {
    for (unsigned i = 0; i < 27; ++i) {
      unsigned parent = 0, child = 0;
      const unsigned offset[3] = {i % 3, i / 3 % 3, i / 9};
      const unsigned scale[3] = {1, 3, 9};
      for (unsigned axis = 0; axis < 3; ++axis) {
        // 1 to 4: the position in units of children, where the block's three nodes take 0-1, 2-3
        // and 4-5.
        const unsigned at = 2 + (octant >> axis & 1u) + offset[axis] - 1;
        parent += at / 2 * scale[axis];
        child |= (at % 2) << axis;
      }
      steps[octant][i] = {static_cast<std::uint8_t>(parent), static_cast<std::uint8_t>(child)};
    }
  }
  return steps;
}
constexpr Steps kSteps = make_steps();

}  // namespace

void child_blocks(const Svo& svo, const NodeBlock& around, NodeBlock* blocks) {
  // All neighbours of this node's children are children of the 27 nodes around it. Number those
  // first, so that each child only has to look its neighbours up.
  std::array<std::array<std::uint32_t, 8>, 27> numbers;
  for (std::size_t i = 0; i < 27; ++i) {
    const unsigned mask = around[i] == kNoNode ? 0 : svo.masks[around[i]];
    std::uint32_t next = around[i] == kNoNode ? 0 : svo.first_child[around[i]];
    for (unsigned octant = 0; octant < 8; ++octant) {
      const bool there = (mask >> octant & 1u) != 0;
      numbers[i][octant] = there ? next : kNoNode;
      next += there ? 1u : 0u;
    }
  }
  for (unsigned octants = svo.masks[around[13]]; octants != 0; octants &= octants - 1) {
    const auto& steps = kSteps[static_cast<std::size_t>(std::countr_zero(octants))];
    NodeBlock& block = *blocks++;
    for (std::size_t i = 0; i < 27; ++i) block[i] = numbers[steps[i].parent][steps[i].octant];
  }
}

std::vector<NodeBlock> node_blocks(const Svo& svo) {
  std::vector<NodeBlock> blocks(svo.node_count());
  if (blocks.empty()) return blocks;
  blocks[0].fill(kNoNode);
  blocks[0][13] = 0;
  for (std::uint32_t node = 0; node < svo.internal_count(); ++node)
    child_blocks(svo, blocks[node], &blocks[svo.first_child[node]]);
  return blocks;
}

}  // namespace pointreel
