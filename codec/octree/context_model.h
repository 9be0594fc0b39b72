#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#if defined(__wasm_simd128__)
#include <wasm_simd128.h>
#endif

#include "codec/octree/alphabet.h"
#include "codec/octree/causal_walk.h"
#include "codec/octree/sparse_words.h"
#include "pointreel/bytes.h"
#include "pointreel/error.h"

/// The alphabets with which masks are coded. A table and the word of a node lead in three steps to
/// an alphabet, which adapts as symbols are coded. FORMAT.md, "Symbols" and "Contexts".
namespace pointreel {

/// Levels of the same class share tables. The class depends on the average number of children of a
/// node.
inline constexpr int kLevelClasses = 6;

/// In the classes below this, the first symbol is the number of a node's only child, or kMore.
inline constexpr int kOnlyChildClasses = 3;
inline constexpr int kMore = 8;
/// From this class on, words tell about the masks of the nodes before (causal_walk.h).
inline constexpr int kFirstCausalClass = kOnlyChildClasses;
/// The class of dense levels.
inline constexpr int kDenseClass = kLevelClasses - 1;

/// Symbols of the same kind share a table in each class.
enum class SymbolKind { only_child, low_half, high_half };
inline constexpr int kTables = 2 * kLevelClasses + kOnlyChildClasses;
constexpr int table_of(int level_class, SymbolKind kind) {
  return 2 * level_class + static_cast<int>(kind) - 1 +
         (level_class < kOnlyChildClasses ? level_class + 1 : kOnlyChildClasses);
}
constexpr bool is_only_child_table(int table) {
  return table < 3 * kOnlyChildClasses && table % 3 == 0;
}
constexpr bool is_causal_table(int table) {
  return table >= table_of(kFirstCausalClass, SymbolKind::low_half);
}

/// Whether a level may belong to a causal class. This bounds the memory for its planes.
constexpr bool may_be_causal(int level, std::size_t nodes) {
  return std::uint64_t{1} << (2 * level) <= 32768 + 32 * std::uint64_t{nodes};
}

/// The class that the encoder chooses for a level. It is stored for the decoder.
int level_class(int level, std::size_t nodes, std::size_t children);

/// The bits of a word that tell a context, at most kMost of them.
template <int kMost>
struct WordBits {
  std::uint64_t mask = 0;
  /// For portable code, which may read all of them; those not needed are 63.
  std::array<std::uint8_t, 8> places;
  static_assert(kMost <= 8);

  explicit WordBits(std::uint64_t bits = 0) : mask(bits) {
    for (std::uint8_t& place : places) {
      place = bits == 0 ? 63 : static_cast<std::uint8_t>(std::countr_zero(bits));
      bits &= bits - 1;
    }
  }
};

/// Moves the bits of a word together, the lowest to bit 0. There are two forms with equal results;
/// the one to use is chosen at run time. Words have no bit 63.
struct PortableExtract {
  template <int kMost>
  static std::size_t extract(std::uint64_t word, const WordBits<kMost>& bits) {
#if defined(__wasm_simd128__)
    // Each lane finds the byte that holds its bit and compares it with the bit alone.
    const v128_t places = wasm_v128_load64_zero(bits.places.data());
    const v128_t powers = wasm_u8x16_make(1, 2, 4, 8, 16, 32, 64, 128, 0, 0, 0, 0, 0, 0, 0, 0);
    const v128_t bit = wasm_i8x16_swizzle(powers, wasm_v128_and(places, wasm_i8x16_splat(7)));
    const v128_t byte = wasm_i8x16_swizzle(wasm_i64x2_splat(static_cast<std::int64_t>(word)),
                                           wasm_u8x16_shr(places, 3));
    const std::uint32_t found = wasm_i8x16_bitmask(wasm_i8x16_eq(wasm_v128_and(byte, bit), bit));
    return found & ((1u << kMost) - 1);
#else
    std::uint64_t gathered = 0;
    for (std::size_t i = 0; i < kMost; ++i) gathered |= (word >> bits.places[i] & 1u) << i;
    return static_cast<std::size_t>(gathered);
#endif
  }
};

#if defined(__x86_64__)
struct HardwareExtract {
  /// Written in assembly, so that code compiled for processors without the instruction can contain
  /// it.
  template <int kMost>
  static std::size_t extract(std::uint64_t word, const WordBits<kMost>& bits) {
    std::uint64_t gathered;
    __asm__("pextq %2, %1, %0" : "=r"(gathered) : "r"(word), "rm"(bits.mask));
    return gathered;
  }
};
#endif

/// Trained tables. With the fields of the table, cell = first_cell + extract(word, bits); with
/// those of the cell, part = first + extract(word, bits); and with those of the part, alphabet =
/// first + extract(word, bits).
struct ContextTables {
  static constexpr int kMostTableBits = 8, kMostCellBits = 5;

  struct Table {
    WordBits<kMostTableBits> bits;
    std::uint32_t first_cell = 0;
  };
  struct Cell {
    WordBits<kMostCellBits> bits;
    std::uint32_t first = 0;
  };
  std::array<Table, kTables> tables;
  std::vector<Cell> cells, parts;
  std::vector<Alphabet16> alphabets;  ///< their state at the beginning of a frame
  /// Identifies a package's own tables in its frames; 0 for the tables of the format.
  std::uint64_t checksum = 0;

  const Table& table(int level_class, SymbolKind kind) const {
    return tables[static_cast<std::size_t>(table_of(level_class, kind))];
  }

  /// The tables of dense levels come last.
  std::size_t first_dense_alphabet() const {
    return parts[cells[tables[kTables - 2].first_cell].first].first;
  }

  /// The index of the alphabet for a symbol of this table.
  template <class Extract>
  std::uint32_t find(const Table& table, std::uint64_t word) const {
    const Cell& cell = cells[table.first_cell + Extract::extract(word, table.bits)];
    const Cell& part = parts[cell.first + Extract::extract(word, cell.bits)];
    return part.first + static_cast<std::uint32_t>(Extract::extract(word, part.bits));
  }
};

/// An alphabet as it is stored in tables.
struct StoredAlphabet {
  std::uint8_t confidence = 0;            ///< 0 to 3
  std::array<std::uint8_t, 16> rarity{};  ///< of each symbol, 0 to 15

  bool operator==(const StoredAlphabet&) const = default;
};
Alphabet16 unpack_alphabet(const StoredAlphabet& stored, int symbols);
/// The rarity that is nearest to a symbol's share.
std::uint8_t rarity_of(double share);
/// The number of symbols that a table stores for each of its alphabets.
constexpr int symbols_of_table(int table) { return is_only_child_table(table) ? kMore + 1 : 16; }

/// The stored part of a table.
struct StoredTable {
  std::uint64_t mask = 0;
  std::vector<std::uint64_t> cells;       ///< the masks of 2^(number of bits in `mask`) cells
  std::vector<std::uint64_t> parts;       ///< for each cell in order, 2^(bits in its mask)
  std::vector<StoredAlphabet> alphabets;  ///< for each part in order, 2^(bits in its mask)
};
/// A mask that stands for a table of the tables that these are based on; nothing else is stored for
/// it.
inline constexpr std::uint64_t kBaseTable = std::uint64_t{1} << 63;

/// Parses stored tables: FORMAT.md, "Tables". `base`: the tables that those with the mask
/// kBaseTable are taken from; null if there are none.
///
/// Trust: the bytes may be hostile, since packages may have their own tables. Masks and counts are
/// bounded (2^16 alphabets) and compared with the size of the data before memory is taken.
Result<ContextTables> parse_tables(ByteView bytes, const ContextTables* base = nullptr);

/// The stored form of tables.
Bytes write_tables(std::span<const StoredTable, kTables> tables);

}  // namespace pointreel
