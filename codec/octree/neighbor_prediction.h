#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "codec/octree/int4.h"
#include "pointreel/octree.h"

/// Predicts the values of children from those of their parent and of the parent's neighbours that
/// touch the child. FORMAT.md, "Prediction".
namespace pointreel {

/// The fourth lane of a node's value is 1, which counts nodes, plus kActivityUnit times its
/// activity, which is how much there was to code in it.
inline constexpr std::int32_t kActivityUnit = 256;
inline constexpr std::int32_t kMostActivity = 127;

/// The range to which stored values are clamped. It leaves room for the sum of three values.
inline constexpr std::int32_t kLeastValue = -16384, kMostValue = 16383;

/// Selects the lanes that hold a value's components.
inline constexpr Int4 kComponents = {-1, -1, -1, 0};

/// The fourth lane of a node with this activity; the other lanes are 0.
inline Int4 fourth_lane(std::int32_t activity) {
  return Int4{0, 0, 0, 1 + activity * kActivityUnit};
}

/// Clamps the components and keeps the fourth lane.
inline Short4 stored_value(const Int4& value) {
  constexpr Int4 kLeast = {kLeastValue, kLeastValue, kLeastValue, 0};
  constexpr Int4 kMost = {kMostValue, kMostValue, kMostValue, 32767};
  return narrow(min(max(value, kLeast), kMost));
}

/// The values of the children of a node and of the cells around them: 4 x 4 x 4 cells of the level
/// below the node, x fastest, of which the middle 2 x 2 x 2 are its own. All lanes are 0 where
/// there is no node.
struct ValueBlock {
  std::array<Short4, 64> values{};

  /// The index of an octant's cell.
  static int cell(int octant) { return 21 + (octant & 1) + (octant & 2) * 2 + (octant & 4) * 4; }

  /// The expected value of child `octant` of the node in `cell`: the weighted mean of that node,
  /// with the weight 18, of its neighbours across the child's three outer faces, with 8 each, and
  /// across its three outer edges, with 3 each. The result is no larger in magnitude than the
  /// largest of them. Adds the weights to `weight` and the weighted activities to `activity`.
  Int4 predict(int cell, int octant, std::int32_t& weight, std::int32_t& activity) const;
};

/// The neighbours of the nodes of a level, and the values of their children. Neighbours are derived
/// level by level from the root down, without any search. Takes 140 bytes for each node of the
/// level.
class Neighborhoods {
 public:
  explicit Neighborhoods(const Svo& svo);

  int level() const { return level_; }
  /// Moves to the next level. The current level is at most svo.depth - 1.
  void descend();

  /// Sets the values of the current level's children. `values`: those of all nodes of the tree.
  void set_values(const Short4* values);
  /// Sets the value of a child of a node of the current level.
  void set_value(std::uint32_t node, int octant, const Short4& value) {
    values_[group_of(node)][static_cast<std::size_t>(octant)] = value;
  }

  /// Loads the values of the cells around a node of the current level.
  void load(std::uint32_t node, ValueBlock& block) const;

 private:
  /// The groups of children of a node and of its neighbours across 6 faces and 12 edges. The number
  /// of a node's group is its index in its level plus one; group 0 stands for a missing node, and
  /// its values are zero.
  using Around = std::array<std::uint32_t, 19>;
  /// A value for each child of a node, zero where there is none.
  template <class T>
  using Group = std::array<T, 8>;

  std::size_t group_of(std::uint32_t node) const {
    return node - svo_->level_begin[static_cast<std::size_t>(level_)] + 1;
  }

  template <class T, class Get>
  std::vector<Group<T>> groups(Get get) const;
  template <class T, std::size_t... kRun>
  static void gather(const Around& around, const std::vector<Group<T>>& groups, T* cells,
                     std::index_sequence<kRun...>);

  const Svo* svo_;
  int level_ = 0;
  std::vector<Around> around_;
  std::vector<Group<Short4>> values_;
};

namespace neighbor_prediction {

inline constexpr int kParentWeight = 18, kFaceWeight = 8, kEdgeWeight = 3;
inline constexpr int kMostWeight = kParentWeight + 3 * kFaceWeight + 3 * kEdgeWeight;
static_assert(kMostWeight < kActivityUnit);

/// 2^16 divided by a sum of weights, rounded down so that a mean never exceeds the largest value.
inline constexpr auto kReciprocals = [] {
  std::array<std::int32_t, kMostWeight + 1> all{};
  for (int weight = 1; weight <= kMostWeight; ++weight) {
    all[static_cast<std::size_t>(weight)] = 65536 / weight;
  }
  return all;
}();

}  // namespace neighbor_prediction

inline Int4 ValueBlock::predict(int cell, int octant, std::int32_t& weight,
                                std::int32_t& activity) const {
  using namespace neighbor_prediction;
  const int x = octant & 1 ? 1 : -1, y = octant & 2 ? 4 : -4, z = octant & 4 ? 16 : -16;
  const auto at = [&](int where) {
    return pointreel::load(values[static_cast<std::size_t>(where)]);
  };
  const Int4 faces = at(cell + x) + at(cell + y) + at(cell + z);
  const Int4 edges = at(cell + x + y) + at(cell + y + z) + at(cell + x + z);
  const Int4 sum = at(cell) * kParentWeight + faces * kFaceWeight + edges * kEdgeWeight;
  const auto fourth = static_cast<std::uint32_t>(sum[3]);
  const std::uint32_t weights = fourth % kActivityUnit;
  weight += static_cast<std::int32_t>(weights);
  activity += static_cast<std::int32_t>(fourth / kActivityUnit);
  const Int4 components = sum & kComponents;
  return (components * kReciprocals[weights] + (1 << 15)) >> 16;
}

}  // namespace pointreel
