#include "common/octree/radix_sort.h"

#include <array>
#include <utility>

namespace pointreel {
namespace {

constexpr int kDigitBits = 11;
constexpr std::uint32_t kBuckets = 1u << kDigitBits;

std::uint32_t digit(std::uint64_t key, int place) {
  return static_cast<std::uint32_t>(key >> (place * kDigitBits)) & (kBuckets - 1);
}

}  // namespace

void radix_sort(std::vector<KeyIndex>& items, int bits) {
  if (items.size() < 2) return;
  const int digits = (bits + kDigitBits - 1) / kDigitBits;
  std::vector<std::array<std::uint32_t, kBuckets>> counts(static_cast<std::size_t>(digits));
  for (const KeyIndex& item : items) {
    for (int place = 0; place < digits; ++place) {
      ++counts[static_cast<std::size_t>(place)][digit(item.key, place)];
    }
  }
  std::vector<KeyIndex> other(items.size());
  for (int place = 0; place < digits; ++place) {
    auto& count = counts[static_cast<std::size_t>(place)];
    if (count[digit(items.front().key, place)] == items.size()) continue;
    std::uint32_t begin = 0;
    for (std::uint32_t& c : count) begin += std::exchange(c, begin);
    for (const KeyIndex& item : items) other[count[digit(item.key, place)]++] = item;
    items.swap(other);
  }
}

}  // namespace pointreel
