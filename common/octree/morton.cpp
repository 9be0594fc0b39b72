#include "common/octree/morton.h"

#include <array>

namespace pointreel {
namespace {

// Seven bits at a time: three look-ups an axis are faster than five rounds of shift and mask, and
// need no instruction-set extension.
constexpr int kDigitBits = 7;
constexpr std::uint32_t kDigitMask = (1u << kDigitBits) - 1;

constexpr std::array<std::uint32_t, 1u << kDigitBits> make_spread_table() {
  std::array<std::uint32_t, 1u << kDigitBits> table{};
  for (std::uint32_t value = 0; value < table.size(); ++value) {
    for (int bit = 0; bit < kDigitBits; ++bit) table[value] |= (value >> bit & 1u) << (3 * bit);
  }
  return table;
}
constexpr auto kSpread = make_spread_table();

std::uint64_t spread(std::uint32_t v) {
  return kSpread[v & kDigitMask] |
         std::uint64_t{kSpread[v >> kDigitBits & kDigitMask]} << (3 * kDigitBits) |
         std::uint64_t{kSpread[v >> (2 * kDigitBits) & kDigitMask]} << (6 * kDigitBits);
}

/// Gathers every third bit, lowest first.
std::uint32_t compact(std::uint64_t v) {
  v &= 0x1249249249249249u;
  v = (v | v >> 2) & 0x10c30c30c30c30c3u;
  v = (v | v >> 4) & 0x100f00f00f00f00fu;
  v = (v | v >> 8) & 0x001f0000ff0000ffu;
  v = (v | v >> 16) & 0x001f00000000ffffu;
  v = (v | v >> 32) & 0x00000000001fffffu;
  return static_cast<std::uint32_t>(v);
}

}  // namespace

std::uint64_t morton_encode(const glm::uvec3& cell) {
  return spread(cell.x) | spread(cell.y) << 1 | spread(cell.z) << 2;
}

glm::uvec3 morton_decode(std::uint64_t key) {
  return {compact(key), compact(key >> 1), compact(key >> 2)};
}

}  // namespace pointreel
