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

/// Large frames are parted into slabs that are coded at the same time. FORMAT.md, "Slabs".
///
/// A level's nodes are known before any of its masks, so each slab sees the nodes of its
/// neighbours, but not their masks. Slabs begin each phase of a level with the same leaves; at its
/// end what they have learnt is put together. So what is lost is the cells beyond the cuts, and
/// what the others learn in the same phase.
namespace pointreel {

inline constexpr int kMostSlabs = 16;
/// Masks of the layer that slabs begin with, for each of them: bounds what few bytes make a reader
/// allocate.
inline constexpr std::size_t kLeastMasksOfSlab = 4096;

/// How many slabs a frame of so many leaves has by default: 1 below 2^20, where a frame takes some
/// hundredths of a second and frames side by side make use of all cores; then one for each 2^19.
int default_slabs(std::size_t leaves);

/// Where the slabs after the first begin, along y (axis 1) or z (axis 2).
struct SlabCuts {
  int axis = 2;
  std::vector<std::uint32_t> begins;
};

/// Parts the level along the longer of y and z into `slabs` of about equal weight, or fewer where
/// it has too few coordinates. `weights` are those of the nodes, in Morton order.
SlabCuts choose_cuts(const RasterLevel& level, std::span<const std::uint32_t> weights, int slabs);

/// The level's slabs: each its own nodes, which are walked, and those next to them.
std::vector<RasterLevel> split(const RasterLevel& level, const SlabCuts& cuts);

/// Number of nodes in the level's slab.
std::size_t count_in_slab(const RasterLevel& level);

/// Gives the nodes in the slab, or those around it, their masks; `masks` are those of the whole
/// level, in Morton order.
void give_masks(RasterLevel& level, ByteView masks, bool in_slab);
/// And back: those in the slab.
void take_masks(const RasterLevel& level, std::span<std::uint8_t> masks);

/// A slab codes a level in phases: first an eighth of its nodes, then up to a quarter, a half, all.
/// (Each ends with a slice.)
inline constexpr int kPhases = 4;
inline std::size_t nodes_of_phases(std::size_t nodes, int phase) {
  return nodes >> (kPhases - 1 - phase);
}

/// The leaves that levels of a class use.
struct LeafRange {
  std::size_t begin, end;
};
LeafRange leaves_of_class(const ContextTables& tables, int level_class);

/// The end of a phase, for leaves [begin, end): `leaves` holds what the slabs began with, and then
/// what they have learnt together.
void merge_leaves(std::span<const std::vector<Leaf>> slabs, LeafRange range,
                  std::vector<Leaf>& leaves);

}  // namespace pointreel
