#pragma once

#include <array>
#include <cstdint>

namespace pointreel {

/// How a surface crosses a cell whose corners lie inside or outside of it: the crossed edges of
/// one connected part make a patch. Corner c of a cell is at (c & 1, c >> 1 & 1, c >> 2 & 1). Edge
/// 4 a + k is along axis a; bit 0 of k is its place along axis (a + 1) % 3, bit 1 along axis (a +
/// 2) % 3.
struct CellPatches {
  static constexpr std::uint8_t kNone = 0xff;
  std::uint8_t count = 0;                 ///< 0 to 4
  std::array<std::uint8_t, 12> of{};      ///< the patch of each edge, or kNone
  std::array<std::uint8_t, 4> corners{};  ///< for each patch, a mask of the ends of its edges
};

/// The corners at both ends of an edge, the one with the smaller coordinate first.
constexpr std::array<int, 2> edge_corners(int edge) {
  const int axis = edge / 4, b = (axis + 1) % 3, c = (axis + 2) % 3;
  const int first = (edge & 1) << b | (edge >> 1 & 1) << c;
  return {first, first | 1 << axis};
}

/// For a mask of the corners inside. Where a face of the cell has its corners inside on a diagonal,
/// they are kept apart, in both cells at this face, so that the patches of neighbouring cells fit
/// together (G. Nielson, "Dual Marching Cubes", 2004).
const CellPatches& cell_patches(std::uint8_t inside);

}  // namespace pointreel
