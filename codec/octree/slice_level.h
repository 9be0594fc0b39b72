#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "pointreel/bytes.h"

/// The nodes of a level of an octree in slice order: by z, and within a slice (the nodes of the
/// same z) in Morton order of x and y. FORMAT.md, "Order". The children of a slice make two slices,
/// in each of which they come as their parents do, so going down a level needs no sorting.
namespace pointreel {

struct SliceLevel {
  struct Slice {
    std::uint32_t z, begin;  ///< `begin`: the slice's first node
  };
  int level = 0;
  std::vector<Slice> slices;        ///< with one more at the end, of which only `begin` is valid
  std::vector<std::uint32_t> x, y;  ///< for each node
  std::vector<std::uint32_t> rank;  ///< for each node, its number in the level in Morton order
  /// For each node, what the contexts of its children take from it (surroundings.h).
  std::vector<std::uint32_t> inherited;
  /// For each node, `inherited` of its parent, and from bit 29 on its own number among the
  /// children.
  std::vector<std::uint32_t> parents;
  Bytes masks;  ///< for each node, once it is known

  /// The arrays above but `slices` and `masks` have this many spare entries at their end.
  static constexpr std::size_t kSpare = 8;

  std::size_t size() const { return masks.size(); }
  std::size_t slice_count() const { return slices.size() - 1; }
};

/// Level 0 of a nonempty tree.
SliceLevel root_level();

/// The number of the first slice whose z is at least this.
std::size_t slice_from(const SliceLevel& level, std::uint32_t z);

/// Replaces `children` by the level below, with masks that are zero. All masks of `level` are
/// known. `first_child`: for each node, by rank, the rank of its first child. `child_count`: the
/// sum of the masks' bits. Takes the same time whatever the masks are.
void expand(const SliceLevel& level, std::span<const std::uint32_t> first_child,
            std::size_t child_count, SliceLevel& children);

}  // namespace pointreel
