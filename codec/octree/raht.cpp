#include "codec/octree/raht.h"

#include <algorithm>
#include <cmath>

namespace pointreel {
namespace {

constexpr std::array<MergeOrder, 256> make_orders() {
  std::array<MergeOrder, 256> orders{};
  for (unsigned mask = 1; mask < 256; ++mask) {
    MergeOrder& order = orders[mask];
    // For each octant that still has a value, the child that holds it, and its weight.
    int child[8] = {}, weight[8] = {};
    for (int octant = 0, count = 0; octant < 8; ++octant) {
      if ((mask >> octant & 1) == 0) continue;
      child[octant] = count++;
      weight[octant] = 1;
    }
    for (int axis = 1; axis <= 4; axis *= 2) {
      for (int octant = 0; octant < 8; ++octant) {
        const int other = octant | axis;
        if (other == octant || weight[other] == 0) continue;
        if (weight[octant] == 0) {
          child[octant] = child[other];
        } else {
          order.pair[order.pairs] = {static_cast<std::uint8_t>(child[octant]),
                                     static_cast<std::uint8_t>(child[other])};
          order.unit_weights[order.pairs] = {static_cast<std::uint8_t>(weight[octant]),
                                             static_cast<std::uint8_t>(weight[other])};
          ++order.pairs;
        }
        weight[octant] += weight[other];
        weight[other] = 0;
      }
    }
    order.size_class = static_cast<std::uint8_t>(order.pairs <= 2 ? order.pairs - (order.pairs > 0)
                                                 : order.pairs <= 4 ? 2
                                                                    : 3);
  }
  return orders;
}

/// In 1/256 of a value. A step below 1/32 of an 8-bit colour value is not worth its bits.
constexpr std::uint64_t kLeastStep = 2 * 256;
constexpr std::uint64_t kMostStep = std::uint64_t{1} << 24;

}  // namespace

constinit const std::array<MergeOrder, 256> kMergeOrders = make_orders();

std::uint32_t square_root(std::uint64_t v) {
  // IEEE 754 roots are the same everywhere. The loops correct for the rounding of v and of the
  // root.
  auto root = static_cast<std::uint64_t>(std::sqrt(static_cast<double>(v)));
  while (root > 0xffffffff || root * root > v) --root;
  while (root < 0xffffffff && (root + 1) * (root + 1) <= v) ++root;
  return static_cast<std::uint32_t>(root);
}

PairScales::PairScales(std::uint32_t luma_step, std::uint32_t chroma_step)
    : luma_step_(luma_step), chroma_step_(chroma_step) {
  table_.reserve(kTabled * kTabled);
  for (std::uint32_t w0 = 1; w0 <= kTabled; ++w0) {
    for (std::uint32_t w1 = 1; w1 <= kTabled; ++w1) table_.push_back(make(w0, w1));
  }
}

PairScale PairScales::make(std::uint32_t w0, std::uint32_t w1) const {
  const std::uint64_t sum = std::uint64_t{w0} + w1;
  const std::uint64_t inverse = square_root((sum << 34) / (std::uint64_t{w0} * w1));
  const auto step = [inverse](std::uint64_t orthonormal) {
    return static_cast<std::int32_t>(
        std::clamp((orthonormal * inverse) >> 11, kLeastStep, kMostStep));
  };
  PairScale scale;
  scale.ratio = static_cast<std::int32_t>(((std::uint64_t{w1} << 14) + sum / 2) / sum);
  scale.steps = Int4{step(luma_step_), step(chroma_step_), step(chroma_step_),
                     static_cast<std::int32_t>(kMostStep)};
  return scale;
}

}  // namespace pointreel
