#include "common/octree/radix_sort.h"

#include <algorithm>
#include <utility>

namespace pointreel {
namespace {

constexpr int kDigitBits = 11;
constexpr std::size_t kBuckets = std::size_t{1} << kDigitBits;

std::size_t digit(std::uint64_t key, int place) {
  return static_cast<std::size_t>(key >> (place * kDigitBits)) & (kBuckets - 1);
}

/// The number of digits is a template parameter so that all shifts are constants.
template <int kDigits, class Item, class Key>
void sort_digits(std::vector<Item>& items, Key key_of) {
  const auto by_key = [&key_of](const Item& a, const Item& b) { return key_of(a) < key_of(b); };
  if (std::is_sorted(items.begin(), items.end(), by_key)) return;
  std::vector<std::uint32_t> counts(kDigits * kBuckets);
  for (const Item& item : items) {
    const std::uint64_t key = key_of(item);
#pragma GCC unroll 6
    for (int place = 0; place < kDigits; ++place) ++counts[place * kBuckets + digit(key, place)];
  }
  std::vector<Item> other(items.size());
#pragma GCC unroll 6
  for (int place = 0; place < kDigits; ++place) {
    std::uint32_t* const next = counts.data() + place * kBuckets;
    if (next[digit(key_of(items.front()), place)] == items.size()) continue;
    std::uint32_t begin = 0;
    for (std::size_t i = 0; i < kBuckets; ++i) begin += std::exchange(next[i], begin);
    for (const Item& item : items) other[next[digit(key_of(item), place)]++] = item;
    items.swap(other);
  }
}

template <class Item, class Key>
void sort_bits(std::vector<Item>& items, int bits, Key key_of) {
  if (items.size() < 2) return;
  if (bits <= kDigitBits) return sort_digits<1>(items, key_of);
  if (bits <= 2 * kDigitBits) return sort_digits<2>(items, key_of);
  if (bits <= 3 * kDigitBits) return sort_digits<3>(items, key_of);
  if (bits <= 4 * kDigitBits) return sort_digits<4>(items, key_of);
  if (bits <= 5 * kDigitBits) return sort_digits<5>(items, key_of);
  sort_digits<6>(items, key_of);
}

}  // namespace

void radix_sort(std::vector<KeyIndex>& items, int bits) {
  sort_bits(items, bits, [](const KeyIndex& item) { return item.key; });
}

void radix_sort(std::vector<std::uint64_t>& items, int bits) {
  sort_bits(items, bits, [](std::uint64_t item) { return item >> kPackedIndexBits; });
}

}  // namespace pointreel
