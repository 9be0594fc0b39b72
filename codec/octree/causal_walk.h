#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <utility>
#include <vector>

#include "codec/octree/node_planes.h"
#include "codec/octree/slice_level.h"

/// The words on which contexts depend in the causal classes, those of levels whose nodes have
/// many children. They tell which children the nodes before have, so each is found once the mask
/// before it is known. FORMAT.md, "Words".
namespace pointreel {

namespace causal_word {

/// The bits of a word in use, and those that hold the lower half of the mask where it is known.
inline constexpr int kBits = 60, kLowHalf = 56;

}  // namespace causal_word

/// Walks over slices of a level. The level must outlive it.
class CausalWalk {
 public:
  /// The size of its planes in bytes.
  static std::uint64_t memory(int level) { return (std::uint64_t{19} << (2 * level)) / 8; }

  explicit CausalWalk(SliceLevel& level);

  /// Calls visit(node, word) for each node of a slice, which returns the node's mask. It is stored
  /// in `level.masks`. Finds what the nodes' children inherit. Slices are visited in increasing
  /// order, without a gap.
  template <class Visit>
  [[gnu::always_inline]] void visit(std::size_t slice, Visit&& visit) {
    nodes_.move_to(slice);
    const std::uint32_t end = level_.slices[slice + 1].begin;
    for (std::uint32_t i = level_.slices[slice].begin; i < end; ++i) {
      const std::uint32_t x = level_.x[i], y = level_.y[i];
      const CellsAround around = nodes_.around(x, y);
      level_.inherited[i] = around.sums();
      const std::uint32_t mask = visit(i, word(around, x, y));
      level_.masks[i] = static_cast<std::uint8_t>(mask);
      set(x, y, mask);
    }
    finish(slice);
  }

 private:
  static constexpr std::uint32_t kMargin = 4;  ///< nodes left of the first

  /// Four bits for each node of a row and its neighbours, from x - 1 on: 0 and 1 are the cells 2x
  /// and 2x + 1 of the lower of the two planes of cells, and 2 and 3 those of the upper one.
  static std::uint32_t three_nodes(const std::uint8_t* row, std::uint32_t x) {
    const std::uint32_t at = x + kMargin - 1;
    std::uint16_t bytes;
    std::memcpy(&bytes, row + at / 2, 2);
    return static_cast<std::uint32_t>(bytes) >> 4 * (at % 2);
  }

  std::uint64_t word(const CellsAround& around, std::uint32_t x, std::uint32_t y) const {
    const std::size_t first = 2 * y * stride_;
    const std::uint8_t* row = below_ + first;
    std::uint64_t word = 0;
    for (int j = 0; j < 4; ++j, row += stride_) {
      // Of the slice below, only the upper cells matter.
      const std::uint32_t cells = three_nodes(row, x);
      word |= std::uint64_t{(cells >> 3 & 1u) | (cells >> 5 & 6u) | (cells >> 7 & 8u)} << 4 * j;
    }
    row = beside_ + first;
    const std::uint32_t before = three_nodes(row, x) >> 1;
    word |= std::uint64_t{(before & 1u) | (before >> 1 & 0x7eu) | (before >> 2 & 0x80u)} << 16;
    for (int j = 0; j < 3; ++j) {
      row += stride_;
      const std::uint32_t cells = three_nodes(row, x);
      word |= std::uint64_t{(cells >> 1 & 1u) | (cells >> 2 & 2u)} << (24 + 2 * j);
    }
    return word | std::uint64_t{around.below} << 30 | std::uint64_t{around.beside & 15u} << 39 |
           std::uint64_t{around.beside >> 5} << 43 | std::uint64_t{around.above} << 47;
  }

  void set(std::uint32_t x, std::uint32_t y, std::uint32_t mask) {
    const std::uint32_t at = x + kMargin, shift = 4 * (at % 2);
    std::uint8_t* row = beside_ + (2 * y + 1) * stride_ + at / 2;
    const auto add = [shift](std::uint8_t& byte, std::uint32_t cells) {
      byte = static_cast<std::uint8_t>(byte | cells << shift);
    };
    add(row[0], (mask & 3u) | (mask >> 2 & 12u));
    add(row[stride_], (mask >> 2 & 3u) | (mask >> 4 & 12u));
  }

  void clear(std::uint8_t* plane, std::size_t slice);
  void finish(std::size_t slice);

  SliceLevel& level_;
  NodePlanes nodes_;
  std::size_t stride_;  ///< bytes of a row
  std::vector<std::uint8_t> bytes_;
  std::uint8_t *below_, *beside_;  ///< of the slice below and of this one, from row -1 on
  std::size_t slice_below_ = kNoSlice;
};

}  // namespace pointreel
