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
/// w1 becomes their difference d = v1 - v0 and their weighted mean. The paper's coefficient is d *
/// sqrt(w0 w1 / (w0 + w1)), which makes the transform orthonormal: here that factor goes into the
/// quantisation step of the difference, so that values stay small integers and means are means.
///
/// Values are small integers (colours: in steps of 1/64 of an 8-bit value); means of nodes come out
/// of the transform.
namespace pointreel {

/// The largest r with r * r <= v.
std::uint32_t square_root(std::uint64_t v);

/// In what order the children of a node with a given mask are merged: their number in the node, not
/// their octant. The mean of a pair takes the place of its first.
struct MergeOrder {
  struct Pair {
    std::uint8_t first, second;
  };
  std::uint8_t pairs = 0;       ///< one fewer than children
  std::uint8_t size_class = 0;  ///< 0 to 3: one, two, three or four, more pairs
  std::array<Pair, 7> pair{};
  /// Weights of the halves where all children weigh 1, 1 to 4.
  std::array<Pair, 7> unit_weights{};
};
extern const std::array<MergeOrder, 256> kMergeOrders;

/// What the weights of a pair mean for its difference.
struct PairScale {
  /// Weight of the second over both, in 1/2^14: the mean is v0 + d * ratio.
  std::int32_t ratio;
  /// Quantisation steps of the components' differences, in 1/256 of a value; fourth lane 2^24.
  Int4 steps;
};

/// Scales for one layer's quantisation steps. A weight is at most 2^29.
class PairScales {
 public:
  /// Steps of orthonormal coefficients, in 1/256 of an 8-bit colour value, 1 to 65535.
  PairScales(std::uint32_t luma_step, std::uint32_t chroma_step);

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

/// Where a pair's mean lies, from its first value.
inline Int4 mean_offset(const Int4& difference, std::int32_t ratio) {
  return (difference * ratio + (1 << 13)) >> 14;
}

/// The scales of all pairs of one node, in the order of merging.
struct NodeScales {
  std::array<const PairScale*, 7> pair;
  std::array<PairScale, 7> made;  ///< those that no table holds
  Int4 least_steps;               ///< the least steps of all pairs
};

/// Merges values[0 .. pairs] in place: values[0] becomes the mean; the difference of each pair goes
/// to `differences`.
inline void merge(const MergeOrder& order, const NodeScales& scales, Int4* values,
                  Int4* differences) {
  for (int i = 0; i < order.pairs; ++i) {
    const auto [first, second] = order.pair[static_cast<std::size_t>(i)];
    const Int4 d = values[second] - values[first];
    differences[i] = d;
    values[first] += mean_offset(d, scales.pair[static_cast<std::size_t>(i)]->ratio);
  }
}

/// Undoes merge: values[0] is the mean.
inline void split(const MergeOrder& order, const NodeScales& scales, Int4* values,
                  const Int4* differences) {
  for (int i = order.pairs - 1; i >= 0; --i) {
    const auto [first, second] = order.pair[static_cast<std::size_t>(i)];
    values[first] -= mean_offset(differences[i], scales.pair[static_cast<std::size_t>(i)]->ratio);
    values[second] = values[first] + differences[i];
  }
}

}  // namespace pointreel
