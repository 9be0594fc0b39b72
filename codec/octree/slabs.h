#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "codec/octree/context_model.h"
#include "codec/octree/raster_walk.h"
#include "pointreel/bytes.h"
#include "pointreel/error.h"
#include "pointreel/octree.h"

/// Large frames are divided into slabs that are coded in parallel. FORMAT.md, "Slabs".
///
/// The nodes of a level are known before any of its masks, so a slab sees the nodes of the slabs
/// next to it, but not their masks. All slabs begin each phase of a level with the same leaves, and
/// at its end their adapted leaves are merged. A slab therefore lacks only the cells beyond its
/// cuts and what the other slabs learn in the same phase.
namespace pointreel {

inline constexpr int kMostSlabs = 16;
/// The layer in which slabs begin must have this many masks for each of them. This bounds the
/// memory that a few bytes can make a reader allocate.
inline constexpr std::size_t kLeastMasksOfSlab = 4096;

/// The default number of slabs of a frame with that many leaves. It is 1 below 2^20 leaves, where a
/// frame takes a few hundredths of a second and coding several frames in parallel uses all cores;
/// from there on, it is one for each 2^19 leaves.
int default_slabs(std::size_t leaves);

/// The coordinates at which all slabs but the first begin, along y (axis 1) or z (axis 2).
struct SlabCuts {
  int axis = 2;
  std::vector<std::uint32_t> begins;
};

/// Divides the level along the longer of y and z into `slabs` slabs of about equal weight, or fewer
/// if it has too few coordinates. `weights`: those of the nodes, in Morton order.
SlabCuts choose_cuts(const RasterLevel& level, std::span<const std::uint32_t> weights, int slabs);

/// The slabs of a level. Each contains its own nodes, which are walked, and the nodes next to them.
std::vector<RasterLevel> split(const RasterLevel& level, const SlabCuts& cuts);

/// The number of nodes inside the level's slab.
std::size_t count_in_slab(const RasterLevel& level);

/// Sets the masks of the nodes inside the slab, or of those around it, from the masks of the whole
/// level in Morton order.
void give_masks(RasterLevel& level, ByteView masks, bool in_slab);
/// The reverse: copies the masks of the nodes inside the slab to those of the whole level.
void take_masks(const RasterLevel& level, std::span<std::uint8_t> masks);

/// A slab codes a level in phases, which end after an eighth, a quarter, a half and all of its
/// nodes, rounded up to whole slices.
inline constexpr int kPhases = 4;
inline std::size_t nodes_of_phases(std::size_t nodes, int phase) {
  return nodes >> (kPhases - 1 - phase);
}

/// The range of the leaves that levels of a class use.
struct LeafRange {
  std::size_t begin, end;
};
LeafRange leaves_of_class(const ContextTables& tables, int level_class);

/// Ends a phase for a range of leaves. `leaves` holds those that the slabs began with, and receives
/// the merged ones.
void merge_leaves(std::span<const std::vector<Leaf>> slabs, LeafRange range,
                  std::vector<Leaf>& leaves);

}  // namespace pointreel
