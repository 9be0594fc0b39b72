#pragma once

#include <algorithm>
#include <array>
#include <cstdint>

#include "codec/octree/int4.h"

/// The region-adaptive hierarchical transform (R. de Queiroz and P. Chou, "Compression of 3D point
/// clouds using a region-adaptive hierarchical transform", IEEE Transactions on Image Processing
/// 2016) in integers, one octree node at a time. FORMAT.md, "Transform".
///
/// Children are merged in pairs along x, then y, then z. A pair of values v0, v1 with weights w0,
/// w1 is replaced by their difference d = v1 - v0 and their weighted mean. The coefficient of de
/// Queiroz and Chou is d * sqrt(w0 w1 / (w0 + w1)), which makes the transform orthonormal. Here,
/// the quantisation step of the difference contains that factor instead, so that values are small
/// integers (for colours, in units of 1/64 of an 8-bit value) and the values of inner nodes are
/// means.
namespace pointreel {

/// The largest r with r * r <= v.
std::uint32_t square_root(std::uint64_t v);

/// The order in which the children of a node with a given mask are merged. Children are identified
/// by their number within the node, not by their octant. The mean of a pair replaces its first
/// child.
struct MergeOrder {
  struct Pair {
    std::uint8_t first, second;
  };
  std::uint8_t pairs = 0;  ///< one fewer than the number of children
  std::array<Pair, 7> pair{};
};
extern const std::array<MergeOrder, 256> kMergeOrders;

/// What follows from the weights of a pair.
struct PairScale {
  /// The weight of the second value divided by that of both, in 1/2^14: the mean is v0 + d * ratio.
  std::int16_t ratio;
  /// A number less than kSmallScales for weights of at most 8, each pair of which has another one,
  /// and kSmallScales for all others.
  std::uint16_t number;
  /// 1 / sqrt(w0 w1 / (w0 + w1)), in 1/2^17.
  std::uint32_t inverse;
};
inline constexpr std::size_t kSmallScales = 64;

/// The scale for two weights, which are at most 2^29.
PairScale make_scale(std::uint32_t w0, std::uint32_t w1);

/// The scales of small weights.
class PairScales {
 public:
  PairScales();

  PairScale operator()(std::uint32_t w0, std::uint32_t w1) const {
    if (((w0 - 1) | (w1 - 1)) < kTabled) return table_[(w0 - 1) * kTabled + w1 - 1];
    return make_scale(w0, w1);
  }

 private:
  static constexpr std::uint32_t kTabled = 32;
  std::array<PairScale, kTabled * kTabled> table_;
};
const PairScales& pair_scales();

/// The quantisation steps of orthonormal coefficients in 64/256 of a value, for each component;
/// less than 2^18.
using ComponentSteps = std::array<std::uint32_t, 3>;

/// The quantisation step of a pair's difference, in 1/256 of a value. A step below 1/32 of an 8-bit
/// colour value is not worth its bits.
inline std::int32_t step_of(const PairScale& scale, std::uint32_t orthonormal) {
  const std::uint64_t step = (std::uint64_t{orthonormal} * scale.inverse) >> 11;
  return static_cast<std::int32_t>(
      std::clamp(step, std::uint64_t{2 * 256}, std::uint64_t{1} << 24));
}

/// step_of for all components, of which the fourth is 1.
class PairSteps {
 public:
  explicit PairSteps(const ComponentSteps& steps);

  Int4 operator()(const PairScale& scale) const {
    return __builtin_expect(scale.number < kSmallScales, 1) ? small_[scale.number] : make(scale);
  }

 private:
  Int4 make(const PairScale& scale) const {
    return Int4{step_of(scale, steps_[0]), step_of(scale, steps_[1]), step_of(scale, steps_[2]), 1};
  }

  ComponentSteps steps_;
  std::array<Int4, kSmallScales> small_;
};

/// The difference between a pair's mean and its first value. Differences are at most 2^17.
inline Int4 mean_offset(const Int4& difference, std::int32_t ratio) {
  return (difference * ratio + (1 << 13)) >> 14;
}

/// The scales of a node's pairs, in the order of merging.
using NodeScales = std::array<PairScale, 7>;

/// The scales of the nodes with a mask whose children all weigh 1.
const NodeScales& unit_scales(std::uint8_t mask);

/// Finds the scales for the weights of a node's children. Eight weights are read, whatever their
/// number: to copy fewer takes longer.
inline void find_scales(const PairScales& scales, const MergeOrder& order,
                        const std::uint32_t* weights, NodeScales& found) {
  std::array<std::uint32_t, 8> weight;
  std::copy_n(weights, 8, weight.begin());
  for (std::size_t i = 0; i < order.pairs; ++i) {
    const auto [first, second] = order.pair[i];
    found[i] = scales(weight[first], weight[second]);
    weight[first] += weight[second];
  }
}

/// Merges values[0 .. pairs] in place, so that values[0] becomes the mean, and stores the
/// difference of each pair in `differences`.
inline void merge(const MergeOrder& order, const NodeScales& scales, Int4* values,
                  Int4* differences) {
  for (std::size_t i = 0; i < order.pairs; ++i) {
    const auto [first, second] = order.pair[i];
    const Int4 d = values[second] - values[first];
    differences[i] = d;
    values[first] += mean_offset(d, scales[i].ratio);
  }
}

/// Undoes merge, from the mean in values[0] and the differences.
inline void split(const MergeOrder& order, const NodeScales& scales, Int4* values,
                  const Int4* differences) {
  for (std::size_t i = order.pairs; i-- > 0;) {
    const auto [first, second] = order.pair[i];
    values[first] -= mean_offset(differences[i], scales[i].ratio);
    values[second] = values[first] + differences[i];
  }
}

}  // namespace pointreel
