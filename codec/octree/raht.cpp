#include "codec/octree/raht.h"

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
          ++order.pairs;
        }
        weight[octant] += weight[other];
        weight[other] = 0;
      }
    }
  }
  return orders;
}

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

PairScale make_scale(std::uint32_t w0, std::uint32_t w1) {
  const std::uint64_t sum = std::uint64_t{w0} + w1;
  const std::uint32_t number = std::max(w0, w1) <= 8 ? 8 * (w0 - 1) + w1 - 1 : kSmallScales;
  return {static_cast<std::int16_t>(((std::uint64_t{w1} << 14) + sum / 2) / sum),
          static_cast<std::uint16_t>(number), square_root((sum << 34) / (std::uint64_t{w0} * w1))};
}

PairSteps::PairSteps(const ComponentSteps& steps) : steps_(steps) {
  for (std::uint32_t w0 = 1; w0 <= 8; ++w0) {
    for (std::uint32_t w1 = 1; w1 <= 8; ++w1) {
      const PairScale scale = pair_scales()(w0, w1);
      small_[scale.number] = make(scale);
    }
  }
}

PairScales::PairScales() {
  for (std::uint32_t w0 = 1; w0 <= kTabled; ++w0) {
    for (std::uint32_t w1 = 1; w1 <= kTabled; ++w1) {
      table_[(w0 - 1) * kTabled + w1 - 1] = make_scale(w0, w1);
    }
  }
}

const PairScales& pair_scales() {
  static const PairScales scales;
  return scales;
}

const NodeScales& unit_scales(std::uint8_t mask) {
  static const std::array<NodeScales, 256> all = [] {
    constexpr std::array<std::uint32_t, 8> kOnes = {1, 1, 1, 1, 1, 1, 1, 1};
    std::array<NodeScales, 256> made{};
    for (std::size_t m = 0; m < 256; ++m) {
      find_scales(pair_scales(), kMergeOrders[m], kOnes.data(), made[m]);
    }
    return made;
  }();
  return all[mask];
}

}  // namespace pointreel
