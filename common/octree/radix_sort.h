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
/// keys: least significant digit first, 11 bits at a time, digits that are the same in all keys
/// skipped. O(n); takes as much memory again as `items`.
void radix_sort(std::vector<KeyIndex>& items, int bits = 63);

}  // namespace pointreel
