#pragma once

#include <cstdint>
#include <vector>

namespace pointreel {

/// A Morton key and the number of the point that it belongs to.
struct KeyIndex {
  std::uint64_t key;
  std::uint32_t index;
};

/// Sorts by the lowest `bits` bits of the keys, which have no others, keeping the order of equal
/// keys: least significant digit first, at most 11 bits at a time, digits that are the same in all
/// keys skipped; nothing is done to what is sorted. O(n); takes as much memory again as `items`.
void radix_sort(std::vector<KeyIndex>& items, int bits = 63);

/// A key of up to 33 bits and a number of 31 bits in one: half as much to move.
inline constexpr int kPackedIndexBits = 31;
/// Sorts such by the lowest `bits` bits of their keys.
void radix_sort(std::vector<std::uint64_t>& items, int bits);

}  // namespace pointreel
