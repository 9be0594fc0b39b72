#include "client/scene/leaf_neighbors.h"

#include <array>
#include <bit>
#include <utility>

namespace pointreel {
namespace {

constexpr std::uint32_t kNone = 0xffffffffu;
constexpr double kClosedGrowth = 3.0;

/// The nodes beside a node on its level, in the directions of NeighborBits.
using Beside = std::array<std::uint32_t, 6>;

/// The neighbour of a child lies in the same parent or in the parent beside it. There it is the
/// child across the axis.
struct Place {
  std::uint32_t parent;  ///< or kNone
  unsigned child;
};
Place place_beside(std::uint32_t parent, const Beside& beside_parent, unsigned child,
                   unsigned direction) {
  const unsigned axis_bit = 1u << direction / 2;
  const bool up = direction % 2 == 1;
  const bool inside = ((child & axis_bit) == 0) == up;
  return {inside ? parent : beside_parent[direction], child ^ axis_bit};
}

}  // namespace

std::vector<NeighborBits> leaf_neighbors(const Svo& svo) {
  std::vector<NeighborBits> leaves(svo.leaf_count(), 0);
  if (svo.depth == 0) return leaves;
  std::vector<Beside> beside(1), beside_children;
  beside[0].fill(kNone);
  for (int level = 0; level < svo.depth; ++level) {
    const bool above_leaves = level + 1 == svo.depth;
    const std::uint32_t first = svo.level_begin[static_cast<std::size_t>(level)];
    const std::uint32_t first_child = svo.level_begin[static_cast<std::size_t>(level) + 1];
    if (!above_leaves) beside_children.resize(svo.node_count(level + 1));
    for (std::uint32_t i = 0; i < svo.node_count(level); ++i) {
      const std::uint32_t parent = first + i;
      std::uint32_t at = svo.first_child[parent] - first_child;
      for (unsigned mask = svo.masks[parent]; mask != 0; mask &= mask - 1, ++at) {
        const auto child = static_cast<unsigned>(std::countr_zero(mask));
        for (unsigned direction = 0; direction < 6; ++direction) {
          const Place place = place_beside(parent, beside[i], child, direction);
          const unsigned siblings = place.parent == kNone ? 0 : svo.masks[place.parent];
          const bool filled = (siblings >> place.child & 1u) != 0;
          if (above_leaves) {
            leaves[at] = static_cast<NeighborBits>(leaves[at] | (filled ? 1u << direction : 0u));
          } else {
            const auto before =
                static_cast<std::uint32_t>(std::popcount(siblings & ((1u << place.child) - 1u)));
            beside_children[at][direction] =
                filled ? svo.first_child[place.parent] + before : kNone;
          }
        }
      }
    }
    std::swap(beside, beside_children);
  }
  return leaves;
}

bool worth_hiding(const Svo& svo) {
  return svo.depth > 0 && svo.leaf_count() >= kClosedGrowth * svo.node_count(svo.depth - 1);
}

}  // namespace pointreel
