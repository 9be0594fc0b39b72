#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <vector>

#include "codec/octree/slice_level.h"

/// Which of the 26 cells around a node are nodes, too. FORMAT.md, "Neighbourhood".
namespace pointreel {

/// The cells around a node and itself, 9 bits for each of z - 1, z and z + 1, x fastest. The
/// node's own bit is 0.
struct CellsAround {
  std::uint32_t below, beside, above;

  std::uint32_t cube() const { return below | beside << 9 | above << 18; }
  /// What contexts need to know of them: the number of nodes at x + 1 from bit 0 on, x - 1 (4),
  /// y + 1 (8), y - 1 (12), z + 1 (16) and z - 1 (20), and of all (24).
  std::uint32_t sums() const;
};

namespace neighborhood {

inline constexpr std::uint32_t kOwnCell = 1u << 4;

/// CellsAround::sums for the nodes of one plane, without z.
inline constexpr auto kPlaneSums = [] {
  std::array<std::uint32_t, 512> all{};
  for (std::uint32_t plane = 0; plane < all.size(); ++plane) {
    for (std::uint32_t i = 0; i < 9; ++i) {
      if ((plane >> i & 1u) == 0) continue;
      const std::uint32_t x = i % 3, y = i / 3;
      all[plane] += (x == 2 ? 1u : 0u) + (x == 0 ? 1u << 4 : 0u) + (y == 2 ? 1u << 8 : 0u) +
                    (y == 0 ? 1u << 12 : 0u) + (1u << 24);
    }
  }
  return all;
}();

}  // namespace neighborhood

inline std::uint32_t CellsAround::sums() const {
  using neighborhood::kPlaneSums;
  const std::uint32_t low = kPlaneSums[below], high = kPlaneSums[above];
  return low + kPlaneSums[beside] + high + (high >> 24 << 16) + (low >> 24 << 20);
}

/// The slices next to a slice, if there are nodes: their numbers, or kNoSlice.
inline constexpr std::size_t kNoSlice = ~std::size_t{0};
std::size_t slice_below(const SliceLevel& level, std::size_t slice);
std::size_t slice_above(const SliceLevel& level, std::size_t slice);

/// Rolling bit planes of a slice's nodes and of those below and above it. Memory is quadratic in
/// the side of the level; time is constant for each node.
class NodePlanes {
 public:
  /// The size of the planes in bytes.
  static std::uint64_t memory(int level) { return (std::uint64_t{3} << (2 * level)) / 8; }

  explicit NodePlanes(const SliceLevel& level);

  /// Moves on to a slice. Slices are visited in increasing order.
  void move_to(std::size_t slice);

  /// What is around the node at (x, y) of the slice.
  CellsAround around(std::uint32_t x, std::uint32_t y) const {
    const std::size_t at = y * stride_ * 8 + x + kMargin - 1;
    return {window(planes_[0].bits, at), window(planes_[1].bits, at) & ~neighborhood::kOwnCell,
            window(planes_[2].bits, at)};
  }

 private:
  static constexpr std::uint32_t kMargin = 8;  ///< columns left of the first cell

  struct Plane {
    std::uint8_t* bits;  ///< from row -1 on
    std::size_t slice;   ///< whose nodes are marked
  };

  /// 3 x 3 bits.
  std::uint32_t window(const std::uint8_t* bits, std::size_t at) const {
    const std::uint8_t* row = bits + at / 8;
    const std::size_t shift = at % 8;
    const auto three = [shift](const std::uint8_t* from) {
      std::uint16_t bytes;
      std::memcpy(&bytes, from, 2);
      return static_cast<std::uint32_t>(bytes) >> shift & 7u;
    };
    return three(row) | three(row + stride_) << 3 | three(row + 2 * stride_) << 6;
  }

  void hold(Plane& plane, std::size_t slice);
  template <class Change>
  void for_each_byte(const Plane& plane, Change&& change);

  const SliceLevel& level_;
  std::size_t stride_;  ///< bytes of a row
  std::vector<std::uint8_t> bytes_;
  std::array<Plane, 3> planes_;  ///< z - 1, z, z + 1
};

/// Finds the same by sorting, for levels whose planes would be too large.
class NodeSearch {
 public:
  explicit NodeSearch(const SliceLevel& level) : level_(level) {}

  /// Calls found(node, cells around it) for each node of a slice. Slices are visited in increasing
  /// order.
  template <class Found>
  void visit(std::size_t slice, Found&& found) {
    move_to(slice);
    const std::uint32_t begin = level_.slices[slice].begin;
    for (std::size_t i = 0; i < around_.size(); ++i) {
      found(begin + static_cast<std::uint32_t>(i), around_[i]);
    }
  }

 private:
  /// A node's place in its slice, by y and then x, and its number in the slice.
  struct Place {
    std::uint64_t key;
    std::uint32_t node;
  };
  struct Sorted {
    std::size_t slice = kNoSlice;
    std::vector<Place> places;
  };

  void move_to(std::size_t slice);
  void hold(Sorted& sorted, std::size_t slice);

  const SliceLevel& level_;
  std::array<Sorted, 3> sorted_;
  std::vector<CellsAround> around_;
};

}  // namespace pointreel
