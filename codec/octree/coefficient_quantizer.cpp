#include "codec/octree/coefficient_quantizer.h"

#include <bit>
#include <cstdint>
#include <cstdlib>

namespace pointreel {
namespace {

/// Fractions of a step are in units of 1/128, and numbers of bits in units of 1/16.
constexpr std::int32_t kStep = 128, kBit = 16;

/// A difference is rounded up to the next multiple of its step from a fraction of 1 - kRounding /
/// 128 on. This is more than a half, since smaller numbers take fewer bits.
constexpr std::int32_t kRounding = 56;

/// The squared error that a bit is worth, in 1/128 of a squared step, for a single coefficient of 1
/// and for all coefficients of a node. It is smaller for a node, because its descendants are
/// predicted from it.
constexpr std::int32_t kWorthOfOne = 22, kWorthOfNode = 8;

/// |difference| is at most 2^16.
std::int32_t steps_in(std::int32_t difference, std::int32_t step) {
  return static_cast<std::int32_t>((static_cast<std::uint32_t>(std::abs(difference)) << 15) /
                                   static_cast<std::uint32_t>(step));
}

/// True if all components of a difference round to zero.
bool rounds_to_zero(const Int4& difference, const Int4& steps) {
  const Int4 above = (abs(difference) << 8) + (steps >> 7) * kRounding >= steps;
  return (above[0] | above[1] | above[2]) == 0;
}

/// By how much the squared error grows if `x` steps are coded as 0 instead of q.
std::int64_t gain(std::int32_t x, std::int32_t q) {
  return std::int64_t{q} * (2 * std::int64_t{x} - std::int64_t{kStep} * q);
}

/// The number of bits that a magnitude and its sign take.
std::int32_t bits_of(const CoefficientContexts& contexts, int k, int activity, std::int32_t q) {
  if (q == 1) return kBit + contexts.above_one[k][activity].cost(0);
  return kBit * (2 + std::bit_width(static_cast<std::uint32_t>(q)));
}

}  // namespace

bool quantize_node(const MergeOrder& order, const NodeScales& scales, std::array<Int4, 8>& values,
                   const CoefficientContexts& contexts, int gradient, int activity,
                   std::array<Triple, 7>& q) {
  Int4 least = values[0], most = values[0];
  for (std::size_t c = 1; c <= order.pairs; ++c) {
    least = min(least, values[c]);
    most = max(most, values[c]);
  }
  // No difference of means is larger than the largest difference of values.
  if (rounds_to_zero(most - least, scales.least_steps)) return false;

  std::array<Int4, 7> differences;
  merge(order, scales, values.data(), differences.data());
  const auto& node = contexts.node[gradient][activity][order.size_class];
  const auto& first = contexts.triple[gradient][0][activity][0];
  const auto& later = contexts.triple[gradient][1][activity][0];
  bool any = false;
  std::int32_t bits = node.cost(1) - node.cost(0);
  std::int64_t gained = 0;
  for (std::size_t i = 0; i < order.pairs; ++i) {
    const Int4& steps = scales.pair[i]->steps;
    Triple& triple = q[i];
    triple = {};
    if (rounds_to_zero(differences[i], steps)) {
      bits += first.cost(0);
      continue;
    }
    Triple x;
    for (int k = 0; k < 3; ++k) {
      const auto c = static_cast<std::size_t>(k);
      x[c] = steps_in(differences[i][k], steps[k]);
      triple[c] = (x[c] + kRounding) / kStep;
    }
    int before = 0;
    for (int k = 0; k < 3; ++k) {
      const auto c = static_cast<std::size_t>(k);
      if (triple[c] == 0) continue;
      if (triple[c] == 1) {
        const bool alone = triple[0] + triple[1] + triple[2] == 1;
        const AdaptiveBit& flag = alone ? later : contexts.component[k][before][activity];
        const std::int32_t more = kBit + flag.cost(1) - flag.cost(0) +
                                  (alone ? 0 : contexts.above_one[k][activity].cost(0));
        if (gain(x[c], 1) * kBit < std::int64_t{more} * kWorthOfOne) {
          triple[c] = 0;
          continue;
        }
      }
      gained += gain(x[c], triple[c]);
      bits += bits_of(contexts, k, activity, triple[c]);
      if (differences[i][k] < 0) triple[c] = -triple[c];
      ++before;
    }
    bits += first.cost(before > 0);
    any = any || before > 0;
  }
  return any && gained * kBit >= std::int64_t{bits} * kWorthOfNode;
}

}  // namespace pointreel
