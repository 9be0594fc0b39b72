#pragma once

#include <cstdint>
#include <vector>

#include "pointreel/octree.h"

namespace pointreel {

/// Which of the six cells beside a leaf are leaves, too: bit 2 a towards lower coordinates of axis
/// a (0 is x, 1 y, 2 z), bit 2 a + 1 towards higher ones.
using NeighborBits = std::uint8_t;

/// The neighbours of all leaves, in the order of the leaves. Takes time linear in the nodes:
/// neighbours of a level's nodes follow from those of the level above.
std::vector<NeighborBits> leaf_neighbors(const Svo& svo);

/// Whether neighbours hide a voxel from an eye in this octant: bit a is set if the eye's coordinate
/// on axis a is the higher one. No more than three faces can be seen (common/FORMULAS.md, "Visible
/// faces").
inline bool hidden(NeighborBits neighbors, unsigned eye_octant) {
  const unsigned x = eye_octant & 1u, y = eye_octant >> 1 & 1u, z = eye_octant >> 2 & 1u;
  const unsigned faces = 1u << x | 4u << y | 16u << z;
  return (neighbors & faces) == faces;
}

/// Whether others hide so many voxels of a tree that it is worth finding out which. A closed
/// surface has about four times as many leaves as parents of leaves. With three times as many a
/// tenth of the leaves is hidden, with four times as many a quarter.
bool worth_hiding(const Svo& svo);

}  // namespace pointreel
