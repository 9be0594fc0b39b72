#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "pointreel/executor.h"

namespace pointreel {

/// A Morton key and the index of the point that it belongs to.
struct KeyIndex {
  std::uint64_t key;
  std::uint32_t index;

  /// Sets nothing: large arrays of them are set by several threads.
  KeyIndex() {}
  KeyIndex(std::uint64_t key_, std::uint32_t index_) : key(key_), index(index_) {}
};

/// The least work on a tree that is worth another thread, in points or nodes.
inline constexpr std::size_t kLeastPerBlock = 1u << 15;

/// Sorts by the keys, which are below 2^bits, and keeps the order of equal keys. A radix sort with
/// digits of 11 bits, least significant first; digits that all keys share are skipped, and sorted
/// items are left alone. O(n); takes as much memory again as `items`. The threads of the executor
/// share the work if there is enough of it.
void radix_sort(std::vector<KeyIndex>& items, int bits = 63, const Executor& executor = {});

/// A key of up to 33 bits above an index of 31 bits. Packed into one word, they are half as much to
/// move.
inline constexpr int kPackedIndexBits = 31;
/// The same for items that are packed in this way. The keys are below 2^bits. `spare` is as large
/// as `items`. Returns the one of the two that holds the sorted items.
std::span<std::uint64_t> radix_sort(std::span<std::uint64_t> items, std::span<std::uint64_t> spare,
                                    int bits, const Executor& executor = {});

}  // namespace pointreel
