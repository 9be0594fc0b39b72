#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "codec/octree/int4.h"
#include "pointreel/octree.h"

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
  std::uint8_t pairs = 0;       ///< one fewer than the number of children
  std::uint8_t size_class = 0;  ///< 0 for up to one pair, 1 for two, 2 for three or four, else 3
  std::array<Pair, 7> pair{};
  /// The weights of the two values of a pair if all children weigh 1; they are 1 to 4.
  std::array<Pair, 7> unit_weights{};
};
extern const std::array<MergeOrder, 256> kMergeOrders;

/// The constants of a pair, which follow from its weights.
struct PairScale {
  /// The weight of the second value divided by that of both, in 1/2^14: the mean is v0 + d * ratio.
  std::int32_t ratio;
  /// The quantisation steps of the components' differences, in 1/256 of a value. The fourth lane is
  /// 2^24.
  Int4 steps;
};

/// The scales of pairs for the quantisation steps of a layer. Weights are at most 2^29.
class PairScales {
 public:
  /// The steps of orthonormal coefficients, in 1/256 of an 8-bit colour value, 1 to 65535.
  PairScales(std::uint32_t luma_step, std::uint32_t chroma_step);

  /// The scale for two weights. Computes it into `made` if it is not in the table.
  const PairScale& operator()(std::uint32_t w0, std::uint32_t w1, PairScale& made) const {
    if (w0 <= kTabled && w1 <= kTabled) return table_[(w0 - 1) * kTabled + w1 - 1];
    made = make(w0, w1);
    return made;
  }

 private:
  static constexpr std::uint32_t kTabled = 16;
  PairScale make(std::uint32_t w0, std::uint32_t w1) const;

  std::uint32_t luma_step_, chroma_step_;
  std::vector<PairScale> table_;
};

/// The difference between a pair's mean and its first value.
inline Int4 mean_offset(const Int4& difference, std::int32_t ratio) {
  return (difference * ratio + (1 << 13)) >> 14;
}

/// The scales of all pairs of a node, in the order of merging.
struct NodeScales {
  std::array<const PairScale*, 7> pair;
  std::array<PairScale, 7> made;  ///< those that are not in a table
  Int4 least_steps;               ///< the least steps of all pairs
};

/// Merges values[0 .. pairs] in place, so that values[0] becomes the mean, and stores the
/// difference of each pair in `differences`.
inline void merge(const MergeOrder& order, const NodeScales& scales, Int4* values,
                  Int4* differences) {
  for (int i = 0; i < order.pairs; ++i) {
    const auto [first, second] = order.pair[static_cast<std::size_t>(i)];
    const Int4 d = values[second] - values[first];
    differences[i] = d;
    values[first] += mean_offset(d, scales.pair[static_cast<std::size_t>(i)]->ratio);
  }
}

/// Undoes merge, from the mean in values[0] and the differences.
inline void split(const MergeOrder& order, const NodeScales& scales, Int4* values,
                  const Int4* differences) {
  for (int i = order.pairs - 1; i >= 0; --i) {
    const auto [first, second] = order.pair[static_cast<std::size_t>(i)];
    values[first] -= mean_offset(differences[i], scales.pair[static_cast<std::size_t>(i)]->ratio);
    values[second] = values[first] + differences[i];
  }
}

}  // namespace pointreel
