#include "client/strips/surfel_changes.h"

#include <algorithm>
#include <bit>
#include <cstring>

#include "common/base/for_each.h"

namespace pointreel {
namespace {

/// Leaves that are compared by one call of the executor.
constexpr std::uint32_t kLeavesPerBlock = 8192;

/// Also true for equal values that are not numbers, and false for zeros of different signs.
template <class T>
bool same_bits(const T& a, const T& b) {
  return std::memcmp(&a, &b, sizeof(T)) == 0;
}

}  // namespace

SurfelChanges::SurfelChanges(const StripSurfels& before, const StripSurfels& now,
                             const Executor& executor)
    : node_before_(now.svo.node_count(), kNoNode),
      same_(now.svo.node_count(), 0),
      surfel_now_(before.svo.leaf_count(), 0) {
  match_nodes(before.svo, now.svo);
  const std::uint32_t internal = now.svo.internal_count();
  const std::uint32_t internal_before = before.svo.internal_count();
  const std::uint32_t leaves = now.svo.leaf_count();
  for_each(executor, static_cast<int>((leaves + kLeavesPerBlock - 1) / kLeavesPerBlock),
           [&](int block) {
             const std::uint32_t begin = static_cast<std::uint32_t>(block) * kLeavesPerBlock;
             for (std::uint32_t i = begin; i < std::min(begin + kLeavesPerBlock, leaves); ++i) {
               if (node_before_[internal + i] == kNoNode) continue;
               const std::uint32_t old = node_before_[internal + i] - internal_before;
               surfel_now_[old] = i;
               same_[internal + i] = same_bits(before.positions[old], now.positions[i]) &&
                                     same_bits(before.normals[old], now.normals[i]) &&
                                     same_bits(before.radii[old], now.radii[i]);
             }
           });
  for (std::uint32_t node = internal; node-- > 0;) {
    const std::uint32_t old = node_before_[node];
    if (old == kNoNode || before.svo.masks[old] != now.svo.masks[node]) continue;
    const std::uint32_t first = now.svo.first_child[node];
    const int children = std::popcount(now.svo.masks[node]);
    std::uint8_t same = 1;
    for (int child = 0; child < children; ++child)
      same &= same_[first + static_cast<std::uint32_t>(child)];
    same_[node] = same;
  }
}

void SurfelChanges::match_nodes(const Svo& before, const Svo& now) {
  if (before.node_count() == 0 || now.node_count() == 0) return;
  node_before_[0] = 0;
  for (std::uint32_t node = 0; node < now.internal_count(); ++node) {
    const std::uint32_t old = node_before_[node];
    if (old == kNoNode) continue;
    const unsigned mask_before = before.masks[old];
    std::uint32_t child = now.first_child[node];
    for (unsigned left = now.masks[node]; left != 0; left &= left - 1, ++child) {
      const unsigned bit = left & (~left + 1);
      if ((mask_before & bit) == 0) continue;
      node_before_[child] = before.first_child[old] +
                            static_cast<std::uint32_t>(std::popcount(mask_before & (bit - 1)));
    }
  }
}

}  // namespace pointreel
