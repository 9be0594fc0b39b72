#pragma once

#include <cstdint>
#include <vector>

namespace pointreel {

/// A Morton key and the index of the point that it belongs to.
struct KeyIndex {
  std::uint64_t key;
  std::uint32_t index;
};

/// Sorts by the keys, which are below 2^bits, and keeps the order of equal keys. A radix sort with
/// digits of 11 bits, least significant first; digits that all keys share are skipped, and sorted
/// items are left alone. O(n); takes as much memory again as `items`.
void radix_sort(std::vector<KeyIndex>& items, int bits = 63);

/// A key of up to 33 bits above an index of 31 bits. Packed into one word, they are half as much to
/// move.
inline constexpr int kPackedIndexBits = 31;
/// The same for items that are packed in this way. The keys are below 2^bits.
void radix_sort(std::vector<std::uint64_t>& items, int bits);

}  // namespace pointreel
