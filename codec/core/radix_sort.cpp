#include "codec/core/radix_sort.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <utility>

#include "common/base/blocks.h"

namespace pointreel {
namespace {

constexpr int kDigitBits = 11;
constexpr std::size_t kBuckets = std::size_t{1} << kDigitBits;

std::size_t digit(std::uint64_t key, int place) {
  return static_cast<std::size_t>(key >> (place * kDigitBits)) & (kBuckets - 1);
}

template <class Item, class Key>
bool is_sorted(std::span<const Item> items, const Blocks& blocks, Key key_of,
               const Executor& executor) {
  std::atomic<bool> sorted{true};
  for_each_block(executor, blocks, [&](std::size_t, std::size_t begin, std::size_t end) {
    // The last item is compared with the first one of the next block.
    const auto last = items.begin() + static_cast<std::ptrdiff_t>(std::min(end + 1, items.size()));
    if (!std::is_sorted(items.begin() + static_cast<std::ptrdiff_t>(begin), last,
                        [&](const Item& a, const Item& b) { return key_of(a) < key_of(b); }))
      sorted = false;
  });
  return sorted;
}

/// Returns the one of the two that holds the sorted items. The number of digits is a template
/// parameter so that all shifts are constants.
template <int kDigits, class Item, class Key>
std::span<Item> sort_digits(std::span<Item> items, std::span<Item> spare, Key key_of,
                            const Executor& executor) {
  const Blocks blocks(executor, items.size(), kLeastPerBlock);
  if (is_sorted(std::span<const Item>(items), blocks, key_of, executor)) return items;
  // A single block counts all digits at once; that of many has other items for each digit.
  const bool at_once = blocks.count() == 1;
  std::vector<std::uint32_t> counts((at_once ? kDigits : blocks.count()) * kBuckets);
  if (at_once) {
    for (const Item& item : items) {
      const std::uint64_t key = key_of(item);
#pragma GCC unroll 6
      for (int place = 0; place < kDigits; ++place) ++counts[place * kBuckets + digit(key, place)];
    }
  }
#pragma GCC unroll 6
  for (int place = 0; place < kDigits; ++place) {
    std::uint32_t* const next = counts.data() + (at_once ? place * kBuckets : 0);
    if (!at_once) {
      for_each_block(executor, blocks, [&](std::size_t block, std::size_t begin, std::size_t end) {
        // Neighbours often share a digit, and each count has to wait for the one before, so that
        // two tables are twice as fast.
        std::array<std::uint32_t, kBuckets> odd{};
        std::uint32_t* const even = next + block * kBuckets;
        std::fill_n(even, kBuckets, 0u);
        const Item* const item = items.data();
        for (; begin + 1 < end; begin += 2) {
          ++even[digit(key_of(item[begin]), place)];
          ++odd[digit(key_of(item[begin + 1]), place)];
        }
        if (begin < end) ++even[digit(key_of(item[begin]), place)];
        for (std::size_t bucket = 0; bucket < kBuckets; ++bucket) even[bucket] += odd[bucket];
      });
    }
    // Items with the same digit keep the order of the blocks.
    std::uint32_t begin = 0, most = 0;
    for (std::size_t bucket = 0; bucket < kBuckets; ++bucket) {
      const std::uint32_t first = begin;
      for (std::size_t block = 0; block < blocks.count(); ++block)
        begin += std::exchange(next[block * kBuckets + bucket], begin);
      most = std::max(most, begin - first);
    }
    if (most == items.size()) continue;
    for_each_block(executor, blocks, [&](std::size_t block, std::size_t first, std::size_t end) {
      std::uint32_t* const of_block = next + block * kBuckets;
      Item* const to = spare.data();
      for (const Item& item : items.subspan(first, end - first))
        to[of_block[digit(key_of(item), place)]++] = item;
    });
    std::swap(items, spare);
  }
  return items;
}

template <class Item, class Key>
std::span<Item> sort_bits(std::span<Item> items, std::span<Item> spare, int bits, Key key_of,
                          const Executor& executor) {
  if (bits <= kDigitBits) return sort_digits<1>(items, spare, key_of, executor);
  if (bits <= 2 * kDigitBits) return sort_digits<2>(items, spare, key_of, executor);
  if (bits <= 3 * kDigitBits) return sort_digits<3>(items, spare, key_of, executor);
  if (bits <= 4 * kDigitBits) return sort_digits<4>(items, spare, key_of, executor);
  if (bits <= 5 * kDigitBits) return sort_digits<5>(items, spare, key_of, executor);
  return sort_digits<6>(items, spare, key_of, executor);
}

}  // namespace

void radix_sort(std::vector<KeyIndex>& items, int bits, const Executor& executor) {
  std::vector<KeyIndex> spare(items.size());
  const auto sorted = sort_bits(
      std::span(items), std::span(spare), bits, [](const KeyIndex& item) { return item.key; },
      executor);
  if (sorted.data() != items.data()) items.swap(spare);
}

std::span<std::uint64_t> radix_sort(std::span<std::uint64_t> items, std::span<std::uint64_t> spare,
                                    int bits, const Executor& executor) {
  return sort_bits(
      items, spare, bits, [](std::uint64_t item) { return item >> kPackedIndexBits; }, executor);
}

}  // namespace pointreel
