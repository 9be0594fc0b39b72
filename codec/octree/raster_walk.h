#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <optional>
#include <span>
#include <vector>

#include "pointreel/bytes.h"

/// The nodes of a level of an octree in raster order (by z, then y, then x), and the walk over them
/// that shows, for each node, the part of its neighbourhood that a decoder knows at that time.
/// FORMAT.md, "Neighbourhood". Any masks are safe, also those that no encoder would make.
namespace pointreel {

/// A level in raster order, which the neighbourhood needs. The SVO is in Morton order, so each node
/// keeps its number in that order.
struct RasterLevel {
  /// Nodes with the same y and z. They end where the next row begins.
  struct Row {
    std::uint32_t y, z, begin;
  };
  /// The part of the level that is walked: begin <= coordinate < end along y (axis 1) or z (axis
  /// 2). Nodes outside it only serve as neighbours of those inside.
  struct Slab {
    int axis = 2;
    std::uint32_t begin = 0, end = 1;
  };
  int level = 0;
  Slab slab;
  std::vector<Row> rows;            ///< with one more at the end, of which only `begin` is valid
  std::vector<std::uint32_t> x;     ///< for each node
  std::vector<std::uint32_t> rank;  ///< for each node, its number in the level in Morton order
  Bytes masks;                      ///< for each node, once it is known
  /// For each node, the 26 nodes around it, as in its neighbourhood word. Set by the walk.
  std::vector<std::uint32_t> around;
  /// For each node, its parent's `around`, and from bit 26 on its own number among the children.
  std::vector<std::uint32_t> parents;

  std::size_t size() const { return x.size(); }
};

/// Makes a walk visit all nodes.
inline constexpr std::size_t kAllNodes = ~std::size_t{0};

/// Level 0 of a nonempty tree.
RasterLevel root_level();

/// Replaces `children` by the level below, with masks that are zero. `first_child`: for each node,
/// by rank, the rank of its first child.
void expand(const RasterLevel& level, std::span<const std::uint32_t> first_child,
            std::size_t child_count, RasterLevel& children);

// --- Neighbourhood word ---

/// The 63 bits on which decisions about a node depend. "Cells" are those of the level below. Bits
/// 28 to 34 hold the node's own children 0 to 6 as far as they are known; the walk leaves them
/// zero.
namespace neighborhood {

inline constexpr int kBelow = 0;     ///< 4 x 4 cells in plane 2z-1, from (2x-1, 2y-1) on, x fastest
inline constexpr int kNearRow = 16;  ///< 4 cells in plane 2z, row 2y-1, from 2x-1 on
inline constexpr int kFarRow = 20;   ///< the same in plane 2z+1
inline constexpr int kLeft = 24;     ///< children 1, 3, 5, 7 of the node at x-1
inline constexpr int kOwn = 28;
inline constexpr int kNodes = 35;    ///< the 26 nodes around the node, z slowest
inline constexpr int kDensity = 61;  ///< class of the number of these: 0-2, 3-5, 6-9, 10 or more
inline constexpr int kBits = 63;

/// `cells`: bits 0 to 27. `nodes`: 27 bits, of which the 14th is the node itself.
inline std::uint64_t word(std::uint32_t cells, std::uint32_t nodes) {
  const std::uint32_t around = (nodes & 0x1fffu) | (nodes >> 14 << 13);
  const unsigned count = static_cast<unsigned>(std::popcount(around));
  const std::uint64_t density =
      (count >= 3 ? 1u : 0u) + (count >= 6 ? 1u : 0u) + (count >= 10 ? 1u : 0u);
  return std::uint64_t{cells} | std::uint64_t{around} << kNodes | density << kDensity;
}

inline constexpr std::uint32_t kAroundBits = (1u << 26) - 1;

/// The bits of `around` whose nodes lie on this side (-1 or 1) along this axis.
constexpr std::uint32_t on_side(int axis, int side) {
  std::uint32_t bits = 0;
  for (int i = 0; i < 27; ++i) {
    const int offset[3] = {i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1};
    if (i != 13 && offset[axis] == side) bits |= 1u << (i < 13 ? i : i - 1);
  }
  return bits;
}

/// The side on which most of the nodes of `around` are: 1 for up, 2 for down, plus 4 if the sides
/// differ by more than two.
template <int axis>
std::uint64_t lean(std::uint32_t around) {
  constexpr std::uint32_t up = on_side(axis, 1), down = on_side(axis, -1);
  // Indexed by the number of nodes above minus that of nodes below, -9 to 9, plus 9.
  static constexpr std::array<std::uint8_t, 19> kLean = {6, 6, 6, 6, 6, 6, 6, 2, 2, 0,
                                                         1, 1, 5, 5, 5, 5, 5, 5, 5};
  return kLean[static_cast<std::size_t>(9 + std::popcount(around & up) -
                                        std::popcount(around & down))];
}

/// The word for decisions in sparse levels. It has only the 12 cells that touch the node's faces,
/// and the surroundings of the node's parent instead of the other cells: where nodes are few, these
/// show more of the surface.
inline std::uint64_t sparse_word(std::uint64_t word, std::uint32_t parent) {
  constexpr std::uint64_t cells = (std::uint64_t{1} << kOwn) - 1;
  const std::uint64_t faces = (word >> (kBelow + 5) & 3u) | (word >> (kBelow + 9) & 3u) << 2 |
                              (word >> (kNearRow + 1) & 3u) << 4 |
                              (word >> (kFarRow + 1) & 3u) << 6 | (word >> kLeft & 15u) << 8;
  const std::uint32_t around = parent & kAroundBits;
  const int count = std::popcount(around);
  const std::uint64_t density =
      (count >= 5 ? 1u : 0u) + (count >= 8 ? 1u : 0u) + (count >= 11 ? 1u : 0u);
  return (word & ~cells) | faces | std::uint64_t{parent >> 26} << 12 | lean<0>(around) << 15 |
         lean<1>(around) << 18 | lean<2>(around) << 21 | density << 24;
}

/// Children 1, 3, 5, 7 of a mask as four bits.
inline std::uint32_t right_half(std::uint32_t mask) {
  return (mask >> 1 & 1u) | (mask >> 2 & 2u) | (mask >> 3 & 4u) | (mask >> 4 & 8u);
}

}  // namespace neighborhood

// --- Neighbours from bit planes ---

/// Finds neighbours in rolling bit planes: three of the nodes' level (the current slice, and those
/// before and after it) and three of the cells' level (below the slice, and the slice's two). Takes
/// constant time for each node. Memory is quadratic in the side of the level.
class PlaneNeighbors {
 public:
  /// The size of the planes for a level, in bytes.
  static std::size_t memory(int level) { return (std::size_t{15} << (2 * level)) / 8; }

  explicit PlaneNeighbors(const RasterLevel& level);

  void begin_slice(std::size_t first_row, std::size_t end_row);
  void end_slice();

  /// Gives the words of the nodes of a row, from left to right.
  class Row {
   public:
    /// `left_mask`: the mask of the node at x - 1, zero if there is none.
    std::uint64_t word(std::uint32_t x, std::uint32_t left_mask) const {
      using namespace neighborhood;
      std::uint32_t cells = from(near_above_, 2 * x, 15) << kNearRow |
                            from(far_above_, 2 * x, 15) << kFarRow | right_half(left_mask) << kLeft;
      const std::uint8_t* row = below_;
      for (int i = 0; i < 4; ++i, row += cell_stride_) cells |= from(row, 2 * x, 15) << (4 * i);
      std::uint32_t nodes = 0;
      for (int plane = 0; plane < 3; ++plane) {
        row = nodes_[static_cast<std::size_t>(plane)];
        for (int i = 0; i < 3; ++i, row += node_stride_) {
          nodes |= from(row, x, 7) << (9 * plane + 3 * i);
        }
      }
      return neighborhood::word(cells, nodes);
    }

    void set(std::uint32_t x, std::uint32_t mask) {
      const std::uint32_t at = 2 * x + kMargin, byte = at / 8, shift = at % 8;
      const auto add = [=](std::uint8_t* row, std::uint32_t cells) {
        row[byte] = static_cast<std::uint8_t>(row[byte] | cells << shift);
      };
      add(near_, mask & 3u);
      add(far_, mask >> 4 & 3u);
      add(near_ + cell_stride_, mask >> 2 & 3u);
      add(far_ + cell_stride_, mask >> 6);
    }

   private:
    friend class PlaneNeighbors;
    /// The bits from column x - 1 on, the lowest first, as many as `mask` has.
    static std::uint32_t from(const std::uint8_t* row, std::uint32_t x, std::uint32_t mask) {
      const std::uint32_t at = x + kMargin - 1;
      std::uint16_t bits;
      std::memcpy(&bits, row + at / 8, 2);
      return static_cast<std::uint32_t>(bits) >> at % 8 & mask;
    }

    const std::uint8_t *below_, *near_above_, *far_above_;
    std::array<const std::uint8_t*, 3> nodes_;
    std::uint8_t *near_, *far_;
    std::size_t cell_stride_, node_stride_;
  };
  Row row(std::size_t number);

 private:
  static constexpr std::uint32_t kMargin = 8;  ///< columns left of the first cell

  struct Rows {
    std::size_t begin = 0, end = 0;
  };
  void mark(std::uint8_t* plane, Rows rows);
  void clear_nodes(std::uint8_t* plane, Rows rows);
  void clear_cells(std::uint8_t* plane, Rows rows);
  Rows next_slice(Rows rows) const;

  const RasterLevel& level_;
  Rows before_, slice_, after_;            ///< the rows whose nodes are marked in the planes
  std::size_t node_stride_, cell_stride_;  ///< the size of a row in bytes
  std::vector<std::uint8_t> bytes_;
  /// Row -1 of each plane. The planes contain this row, and some rows after the last.
  std::uint8_t *nodes_before_, *nodes_, *nodes_after_;
  std::uint8_t *cells_below_, *cells_near_, *cells_far_;
};

// --- Neighbours by searching ---

/// Finds neighbours by searching the sorted rows, for levels whose planes would be too large. Takes
/// no memory. The time for a node does not depend on the side of the level.
class SearchNeighbors {
 public:
  explicit SearchNeighbors(const RasterLevel& level) : level_(level) {}

  void begin_slice(std::size_t first_row, std::size_t end_row);
  void end_slice() {}

  class Row {
   public:
    /// As in PlaneNeighbors, but x must increase from call to call.
    std::uint64_t word(std::uint32_t x, std::uint32_t left_mask);
    void set(std::uint32_t, std::uint32_t) {}

   private:
    friend class SearchNeighbors;
    struct Range {
      std::uint32_t next = 0, end = 0;
    };
    const RasterLevel* level_ = nullptr;
    std::array<Range, 9> rows_;  ///< the rows around this one and itself, z slowest
  };
  Row row(std::size_t number);

 private:
  Row::Range find(std::size_t begin, std::size_t end, std::uint32_t y) const;

  const RasterLevel& level_;
  std::array<std::size_t, 4> slices_{};  ///< the rows at which slices z-1, z, z+1 begin and end
};

// --- Walk ---

/// Calls `visit(row, node, x, word)`, which returns the node's mask, for each node of these rows.
template <class Neighbors, class Visit>
[[gnu::always_inline]] inline void for_each_node(RasterLevel& level, Neighbors& neighbors,
                                                 std::size_t first_row, std::size_t end_row,
                                                 Visit&& visit) {
  for (std::size_t r = first_row; r < end_row; ++r) {
    auto row = neighbors.row(r);
    const std::uint32_t row_end = level.rows[r + 1].begin;
    std::uint32_t after_left = ~0u, mask = 0;  // x right of the last node, and that node's mask
    for (std::uint32_t i = level.rows[r].begin; i < row_end; ++i) {
      const std::uint32_t x = level.x[i];
      const std::uint64_t word = row.word(x, x == after_left ? mask : 0u);
      level.around[i] =
          static_cast<std::uint32_t>(word >> neighborhood::kNodes) & neighborhood::kAroundBits;
      after_left = x + 1;
      mask = visit(row, i, x, word);
    }
  }
}

/// The rows of a slice (the nodes with the same z) that are inside the level's slab.
struct RowRange {
  std::size_t begin, end;
};
RowRange rows_in_slab(const RasterLevel& level, std::size_t begin, std::size_t end);

/// A walk that can be interrupted between slices. The level must outlive it.
template <class Neighbors>
class SliceWalk {
 public:
  explicit SliceWalk(RasterLevel& level) : level_(level), neighbors_(level) {}
  SliceWalk(const SliceWalk&) = delete;
  SliceWalk& operator=(const SliceWalk&) = delete;

  /// Continues until at least `count` nodes of the slab have been walked in all, or it ends. Calls
  /// `visit(node, word)` for each node in raster order. This returns the node's mask, which is
  /// stored in `level.masks` and seen by the nodes after it.
  template <class Visit>
  void visit(std::size_t count, Visit&& visit) {
    visit_slices(count, [&](const RowRange& rows) {
      for_each_node(level_, neighbors_, rows.begin, rows.end,
                    [&](auto& row, std::uint32_t i, std::uint32_t x, std::uint64_t word) {
                      const std::uint32_t mask = visit(i, word);
                      level_.masks[i] = static_cast<std::uint8_t>(mask);
                      row.set(x, mask);
                      return mask;
                    });
    });
  }

  /// The same if `level.masks` is known beforehand inside the slab, and zero around it. Calls
  /// `visit(first node, words)` for the nodes of a slice at a time. Words can then be computed
  /// independently of each other, which is faster.
  template <class Visit>
  void visit_known(std::size_t count, Visit&& visit) {
    visit_slices(count, [&](const RowRange& rows) {
      for (std::size_t r = rows.begin; r < rows.end; ++r) {
        auto row = neighbors_.row(r);
        const std::uint32_t row_end = level_.rows[r + 1].begin;
        for (std::uint32_t i = level_.rows[r].begin; i < row_end; ++i) {
          row.set(level_.x[i], level_.masks[i]);
        }
      }
      const std::uint32_t begin = level_.rows[rows.begin].begin;
      words_.resize(level_.rows[rows.end].begin - begin);
      for_each_node(level_, neighbors_, rows.begin, rows.end,
                    [&](auto&, std::uint32_t i, std::uint32_t, std::uint64_t word) {
                      words_[i - begin] = word;
                      return std::uint32_t{level_.masks[i]};
                    });
      visit(begin, std::span<const std::uint64_t>(words_));
    });
  }

 private:
  /// Calls `visit_rows(rows)` for the slab's rows of each slice.
  template <class VisitRows>
  void visit_slices(std::size_t count, VisitRows&& visit_rows) {
    const std::size_t rows = level_.rows.size() - 1;
    while (next_row_ < rows && walked_ < count) {
      const std::size_t slice = next_row_++;
      while (next_row_ < rows && level_.rows[next_row_].z == level_.rows[slice].z) ++next_row_;
      neighbors_.begin_slice(slice, next_row_);
      const RowRange in = rows_in_slab(level_, slice, next_row_);
      if (in.begin < in.end) visit_rows(in);
      walked_ += level_.rows[in.end].begin - level_.rows[in.begin].begin;
      neighbors_.end_slice();
    }
  }

  RasterLevel& level_;
  Neighbors neighbors_;
  std::size_t next_row_ = 0, walked_ = 0;
  std::vector<std::uint64_t> words_;
};

/// The fastest walk for a level. It uses planes if they take only a few bytes for each node, or if
/// they are not huge and searching would take longer than clearing them.
class LevelWalk {
 public:
  static constexpr std::size_t kHugePlanes = std::size_t{8} << 20, kManyNodes = 4096;

  explicit LevelWalk(RasterLevel& level) {
    const std::size_t planes = PlaneNeighbors::memory(level.level);
    if (planes <= 65536 + 64 * level.size() ||
        (planes <= kHugePlanes && level.size() >= kManyNodes)) {
      by_planes_.emplace(level);
    } else {
      by_searching_.emplace(level);
    }
  }

  template <class Visit>
  void visit(std::size_t count, Visit&& visit) {
    if (by_planes_) {
      by_planes_->visit(count, visit);
    } else {
      by_searching_->visit(count, visit);
    }
  }
  template <class Visit>
  void visit_known(std::size_t count, Visit&& visit) {
    if (by_planes_) {
      by_planes_->visit_known(count, visit);
    } else {
      by_searching_->visit_known(count, visit);
    }
  }

 private:
  std::optional<SliceWalk<PlaneNeighbors>> by_planes_;
  std::optional<SliceWalk<SearchNeighbors>> by_searching_;
};

}  // namespace pointreel
