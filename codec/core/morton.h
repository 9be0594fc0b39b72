#pragma once

#include <array>
#include <cstdint>

#include <glm/glm.hpp>

namespace pointreel {

namespace morton {

// Keys are made from tables of seven bits: this is faster than five rounds of shift and mask, and
// needs no instruction-set extension.
inline constexpr int kDigitBits = 7;
inline constexpr std::uint32_t kDigitMask = (1u << kDigitBits) - 1;

inline constexpr auto kSpread = [] {
  std::array<std::uint32_t, 1u << kDigitBits> table{};
  for (std::uint32_t value = 0; value < table.size(); ++value) {
    for (int bit = 0; bit < kDigitBits; ++bit) table[value] |= (value >> bit & 1u) << (3 * bit);
  }
  return table;
}();

/// Moves bit i to bit 3i. v < 2^14.
inline std::uint64_t spread_short(std::uint32_t v) {
  return kSpread[v & kDigitMask] | std::uint64_t{kSpread[v >> kDigitBits]} << (3 * kDigitBits);
}

/// The same for v < 2^21.
inline std::uint64_t spread(std::uint32_t v) {
  return spread_short(v & ((1u << 2 * kDigitBits) - 1)) |
         std::uint64_t{kSpread[v >> (2 * kDigitBits) & kDigitMask]} << (6 * kDigitBits);
}

}  // namespace morton

/// Interleaves three coordinates below 2^21: bit i of x, y and z becomes bit 3i, 3i + 1 and 3i + 2
/// of the key. Each level of the tree therefore takes three bits of the key, x lowest, and they are
/// the number of the child that contains the cell, which is also its bit in the parent's mask.
inline std::uint64_t morton_encode(const glm::uvec3& cell) {
  if ((cell.x | cell.y | cell.z) >> (2 * morton::kDigitBits) == 0) {
    return morton::spread_short(cell.x) | morton::spread_short(cell.y) << 1 |
           morton::spread_short(cell.z) << 2;
  }
  return morton::spread(cell.x) | morton::spread(cell.y) << 1 | morton::spread(cell.z) << 2;
}

/// The inverse of morton_encode.
glm::uvec3 morton_decode(std::uint64_t key);

}  // namespace pointreel
