#pragma once

#include <array>
#include <cstdint>

#include <glm/glm.hpp>

namespace pointreel {

namespace morton {

// Seven bits at a time: look-ups are faster than five rounds of shift and mask, and need no
// instruction-set extension.
inline constexpr int kDigitBits = 7;
inline constexpr std::uint32_t kDigitMask = (1u << kDigitBits) - 1;

inline constexpr auto kSpread = [] {
  std::array<std::uint32_t, 1u << kDigitBits> table{};
  for (std::uint32_t value = 0; value < table.size(); ++value) {
    for (int bit = 0; bit < kDigitBits; ++bit) table[value] |= (value >> bit & 1u) << (3 * bit);
  }
  return table;
}();

/// Bit i becomes bit 3i, for numbers of up to two digits.
inline std::uint64_t spread_short(std::uint32_t v) {
  return kSpread[v & kDigitMask] | std::uint64_t{kSpread[v >> kDigitBits]} << (3 * kDigitBits);
}

inline std::uint64_t spread(std::uint32_t v) {
  return spread_short(v & ((1u << 2 * kDigitBits) - 1)) |
         std::uint64_t{kSpread[v >> (2 * kDigitBits) & kDigitMask]} << (6 * kDigitBits);
}

}  // namespace morton

/// Interleaves three coordinates below 2^21: bit i of x, y, z becomes bit 3i, 3i + 1, 3i + 2 of the
/// key. The child of a node that a key enters at the next level is therefore the key's next three
/// bits, x lowest, which is also the bit that the child has in its parent's mask.
inline std::uint64_t morton_encode(const glm::uvec3& cell) {
  using namespace morton;
  if ((cell.x | cell.y | cell.z) >> (2 * kDigitBits) == 0) {
    return spread_short(cell.x) | spread_short(cell.y) << 1 | spread_short(cell.z) << 2;
  }
  return spread(cell.x) | spread(cell.y) << 1 | spread(cell.z) << 2;
}

/// The inverse of morton_encode.
glm::uvec3 morton_decode(std::uint64_t key);

}  // namespace pointreel
