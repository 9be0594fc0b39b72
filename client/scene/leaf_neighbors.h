#pragma once

#include <cstdint>
#include <vector>

#include "pointreel/octree.h"

namespace pointreel {

/// Which of the six cells beside a leaf are leaves too: bit 2 a towards lower coordinates of axis a
/// (0 x, 1 y, 2 z), bit 2 a + 1 towards higher ones.
using NeighborBits = std::uint8_t;

/// Of every leaf, in their order. Linear in the nodes: neighbours of a level's nodes follow from
/// those of the level above.
std::vector<NeighborBits> leaf_neighbors(const Svo& svo);

/// Whether neighbours hide a voxel from an eye that sees it from this octant: bit a is set where
/// the eye's coordinate is the higher one. Three faces at most can be seen (paper 2, section VI-B).
inline bool hidden(NeighborBits neighbors, unsigned eye_octant) {
  const unsigned x = eye_octant & 1u, y = eye_octant >> 1 & 1u, z = eye_octant >> 2 & 1u;
  const unsigned faces = 1u << x | 4u << y | 16u << z;
  return (neighbors & faces) == faces;
}

/// Whether so many voxels of a tree are hidden by others that it is worth finding out which. Leaves
/// of a closed surface are about four times as many as their parents; a tenth of them is hidden at
/// three times as many, a quarter at four.
bool worth_hiding(const Svo& svo);

}  // namespace pointreel
