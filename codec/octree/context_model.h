#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "codec/octree/raster_walk.h"
#include "pointreel/bytes.h"
#include "pointreel/error.h"

/// Which probability a decision about a node's children has: its slot and the node's neighbourhood
/// word lead through two tables to a leaf, which adapts as decisions are coded. FORMAT.md,
/// "Contexts".
namespace pointreel {

/// Levels of one class share tables. Classes go by the branching factor: children a node.
inline constexpr int kLevelClasses = 6;
/// Slots 0 to 7: whether the node has that child. 8: whether it has exactly one. 9 to 15: which one
/// that is, as a path down a binary tree: 9 for bit 2 of the child's number, 10 + bit 2 for bit 1,
/// 12 + 2 bit 2 + bit 1 for bit 0.
inline constexpr int kSlots = 16;
inline constexpr int kOnlyChildSlot = 8;
inline constexpr int kPositionSlot = 9;

/// The class that an encoder gives a level; a decoder is told it.
int level_class(std::size_t nodes, std::size_t children);

/// In the classes of few children a node's first decision is whether it has exactly one.
inline bool codes_only_child(int level_class) { return level_class < 3; }

/// Probability of a one, and how much is known of it.
struct Leaf {
  std::uint16_t probability = 32768;  ///< of 65536; kLeastProbability to 65536 - kLeastProbability
  std::uint16_t count = 0;            ///< of the decisions that it stands for, up to kCountLimit
};
inline constexpr int kLeastProbability = 32;
inline constexpr std::uint32_t kCountLimit = 255;

/// How far a leaf moves towards a decision, of 65536: after n decisions about 1 / (n + 1.6).
inline constexpr auto kAdaptationRates = [] {
  std::array<std::uint16_t, kCountLimit + 1> rates{};
  for (std::uint32_t n = 0; n < rates.size(); ++n) {
    rates[n] = static_cast<std::uint16_t>(655360u / (10u * n + 16u));
  }
  return rates;
}();

inline void adapt(Leaf& leaf, unsigned bit) {
  const std::int32_t probability = leaf.probability;
  const std::uint32_t count = leaf.count;
  const std::int32_t aim = static_cast<std::int32_t>((0u - bit) & 65535u);  // without a branch
  std::int32_t moved = probability + ((aim - probability) * kAdaptationRates[count] >> 16);
  moved = moved < kLeastProbability ? kLeastProbability : moved;
  moved = moved > 65536 - kLeastProbability ? 65536 - kLeastProbability : moved;
  leaf.probability = static_cast<std::uint16_t>(moved);
  leaf.count = static_cast<std::uint16_t>(count + (count < kCountLimit ? 1u : 0u));
}

/// Trained tables: cell = first_cell + extract(word, mask) of the slot, leaf = first_leaf +
/// extract(word, mask) of the cell.
struct ContextTables {
  struct Slot {
    std::uint64_t mask = 0;
    std::uint32_t first_cell = 0;
  };
  struct Cell {
    std::uint64_t mask = 0;
    std::uint32_t first_leaf = 0;
  };
  std::array<std::array<Slot, kSlots>, kLevelClasses> slots;
  std::vector<Cell> cells;
  std::vector<Leaf> leaves;  ///< as they are when a frame begins
  /// Of tables that are not part of the codec: what their frames name them by.
  std::uint64_t checksum = 0;
};

/// A leaf as tables store it: six bits of log odds, two of confidence.
Leaf unpack_leaf(std::uint8_t packed);
/// The nearest that can be stored, to a share of ones and the number of decisions it comes from.
std::uint8_t pack_leaf(double probability, double decisions);

/// One slot's part of tables as they are stored.
struct SlotTables {
  std::uint64_t mask = 0;
  std::vector<std::uint64_t> cells;  ///< masks, 2^(ones in `mask`)
  Bytes leaves;                      ///< packed, 2^(ones in a cell's mask) for each cell in order
};
/// As a slot's mask: the slot is as in the tables that these are based on, and nothing of it
/// stored.
inline constexpr std::uint64_t kBaseSlot = std::uint64_t{1} << 63;

/// FORMAT.md, "Tables". `base`: what slots of mask kBaseSlot are taken from; null: there are none.
/// Trust: takes hostile bytes (a package's own tables). Masks and counts are bounded (2^18 cells,
/// 2^20 leaves) and compared with the bytes that are there before memory is taken.
Result<ContextTables> parse_tables(ByteView bytes, const ContextTables* base = nullptr);

/// `slots`: all of class 0, then all of class 1, and so on.
Bytes write_tables(std::span<const SlotTables, kLevelClasses * kSlots> slots);

/// Looks contexts up, with leaves of its own.
template <class Extract>
class ContextLookup {
 public:
  ContextLookup(const ContextTables& tables, int level_class, std::vector<Leaf>& leaves)
      : slots_(tables.slots[static_cast<std::size_t>(level_class)].data()),
        cells_(tables.cells.data()),
        leaves_(leaves.data()) {}

  Leaf& operator()(int slot, std::uint64_t word) const { return leaves_[number(slot, word)]; }
  Leaf& leaf(std::uint32_t number) const { return leaves_[number]; }

  /// The leaf's number.
  std::uint32_t number(int slot, std::uint64_t word) const {
    const ContextTables::Slot& s = slots_[slot];
    const ContextTables::Cell& cell = cells_[s.first_cell + Extract::extract(word, s.mask)];
    return cell.first_leaf + static_cast<std::uint32_t>(Extract::extract(word, cell.mask));
  }

 private:
  const ContextTables::Slot* slots_;
  const ContextTables::Cell* cells_;
  Leaf* leaves_;
};

/// Says what there is to decide about a node with this (non-zero) mask: `code(slot, word, bit)`
/// for each decision in order.
template <class Code>
[[gnu::always_inline]] inline void for_each_decision(bool only_child_first, std::uint64_t word,
                                                     std::uint32_t mask, Code&& code) {
  const bool only = std::has_single_bit(mask);
  if (only_child_first) {
    code(kOnlyChildSlot, word, static_cast<unsigned>(only));
    if (only) {
      const unsigned child = static_cast<unsigned>(std::countr_zero(mask));
      code(kPositionSlot, word, child >> 2);
      code(kPositionSlot + 1 + static_cast<int>(child >> 2), word, child >> 1 & 1u);
      code(kPositionSlot + 3 + static_cast<int>(child >> 1), word, child & 1u);
      return;
    }
  }
  // The last children are known where without them there would be too few.
  const int least = only_child_first ? 2 : 1;
  std::uint32_t own = 0;
#pragma GCC unroll 8
  for (int child = 0; child < 8; ++child) {
    if (child + least >= 8 && std::popcount(own) + 8 - child <= least) return;
    code(child, word | std::uint64_t{own} << neighborhood::kOwn, mask >> child & 1u);
    own |= mask & 1u << child;
  }
}

}  // namespace pointreel
