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

/// The probabilities of decisions about a node's children. The slot of a decision and the node's
/// neighbourhood word lead through two tables to a leaf, which adapts as decisions are coded.
/// FORMAT.md, "Contexts".
namespace pointreel {

/// Levels of the same class share tables. The class depends on the average number of children of a
/// node.
inline constexpr int kLevelClasses = 6;
/// Slots 0 to 7 decide whether the node has that child, and slot 8 whether it has exactly one
/// child. Slots 9 to 15 decide the number of that child, as a path down a binary tree: 9 decides
/// bit 2 of the number, 10 + bit 2 decides bit 1, and 12 + 2 bit 2 + bit 1 decides bit 0.
inline constexpr int kSlots = 16;
inline constexpr int kOnlyChildSlot = 8;
inline constexpr int kPositionSlot = 9;

/// The class that the encoder chooses for a level. It is stored for the decoder.
int level_class(std::size_t nodes, std::size_t children);

/// In the classes with few children, the first decision is whether a node has exactly one child.
inline bool codes_only_child(int level_class) { return level_class < 3; }

/// An adaptive probability that a decision is 1.
struct Leaf {
  std::uint16_t probability = 32768;  ///< of 65536; kLeastProbability to 65536 - kLeastProbability
  std::uint16_t count = 0;            ///< of the decisions that it reflects, up to kCountLimit
};
inline constexpr int kLeastProbability = 32;
inline constexpr std::uint32_t kCountLimit = 255;

/// How far a leaf moves towards a decision, out of 65536: about 1 / (n + 1.6) after n decisions.
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
  const std::int32_t aim = static_cast<std::int32_t>((0u - bit) & 65535u);  // avoids a branch
  std::int32_t moved = probability + ((aim - probability) * kAdaptationRates[count] >> 16);
  moved = moved < kLeastProbability ? kLeastProbability : moved;
  moved = moved > 65536 - kLeastProbability ? 65536 - kLeastProbability : moved;
  leaf.probability = static_cast<std::uint16_t>(moved);
  leaf.count = static_cast<std::uint16_t>(count + (count < kCountLimit ? 1u : 0u));
}

/// Trained tables. With the fields of the slot, cell = first_cell + extract(word, mask); with those
/// of the cell, leaf = first_leaf + extract(word, mask).
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
  std::vector<Leaf> leaves;  ///< their state at the beginning of a frame
  /// Identifies a package's own tables in its frames; 0 for the tables of the format.
  std::uint64_t checksum = 0;
};

/// Unpacks a leaf as it is stored in tables: six bits of log odds and two of confidence.
Leaf unpack_leaf(std::uint8_t packed);
/// The stored leaf that is nearest to a share of ones among a number of decisions.
std::uint8_t pack_leaf(double probability, double decisions);

/// The part of stored tables that belongs to a slot.
struct SlotTables {
  std::uint64_t mask = 0;
  std::vector<std::uint64_t> cells;  ///< the masks of 2^(number of bits in `mask`) cells
  Bytes leaves;  ///< for each cell in order, 2^(number of bits in its mask) packed leaves
};
/// A mask that stands for a slot of the tables that these are based on; nothing else is stored for
/// the slot.
inline constexpr std::uint64_t kBaseSlot = std::uint64_t{1} << 63;

/// Parses stored tables: FORMAT.md, "Tables". `base`: the tables that slots with the mask kBaseSlot
/// are taken from; null if there are none.
///
/// Trust: the bytes may be hostile, since packages may have their own tables. Masks and counts are
/// bounded (2^18 cells, 2^20 leaves) and compared with the size of the data before memory is taken.
Result<ContextTables> parse_tables(ByteView bytes, const ContextTables* base = nullptr);

/// The stored form of tables. `slots`: those of class 0, then those of class 1, and so on.
Bytes write_tables(std::span<const SlotTables, kLevelClasses * kSlots> slots);

/// Looks up the leaves of contexts. The leaves are separate from the tables, since they adapt.
template <class Extract>
class ContextLookup {
 public:
  ContextLookup(const ContextTables& tables, int level_class, std::vector<Leaf>& leaves)
      : slots_(tables.slots[static_cast<std::size_t>(level_class)].data()),
        cells_(tables.cells.data()),
        leaves_(leaves.data()) {}

  Leaf& operator()(int slot, std::uint64_t word) const { return leaves_[number(slot, word)]; }
  Leaf& leaf(std::uint32_t number) const { return leaves_[number]; }

  /// The index of the leaf for a slot and a neighbourhood word.
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

/// Calls `code(slot, word, bit)` for each decision about a node with this mask (not 0), in order.
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
  // The last children need no decision if the node must have them to have enough.
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
