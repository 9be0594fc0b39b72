#include "codec/octree/level_prediction.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstring>

namespace pointreel {
namespace {

typedef float Float4 __attribute__((vector_size(16)));
typedef double Double2 __attribute__((vector_size(16)));

constexpr std::int32_t kParentWeight = 18, kFaceWeight = 8, kEdgeWeight = 3;
constexpr std::int32_t kMostWeight = kParentWeight + 3 * kFaceWeight + 3 * kEdgeWeight;
static_assert(kMostWeight < kActivityUnit);

/// 2^16 divided by a sum of weights, rounded down so that a mean never exceeds the largest value.
constexpr auto kReciprocals = [] {
  std::array<std::int32_t, kMostWeight + 1> all{};
  for (int weight = 1; weight <= kMostWeight; ++weight) {
    all[static_cast<std::size_t>(weight)] = 65536 / weight;
  }
  return all;
}();

/// 2^26 divided by the sum of a node's weights, rounded up: exact quotients of activities.
constexpr auto kActivityReciprocals = [] {
  std::array<std::uint32_t, 8 * kMostWeight + 1> all{};
  for (std::uint32_t weight = 1; weight < all.size(); ++weight) {
    all[weight] = ((1u << 26) + weight - 1) / weight;
  }
  return all;
}();

/// The class by twice the mean activity.
constexpr auto kClasses = [] {
  std::array<std::uint8_t, 97> all{};
  for (int twice = 0; twice < 97; ++twice) {
    all[static_cast<std::size_t>(twice)] =
        static_cast<std::uint8_t>(1 + (twice >= 1) + (twice >= 2) + (twice >= 5) + (twice >= 12) +
                                  (twice >= 24) + (twice >= 48) + (twice >= 96));
  }
  return all;
}();

/// The same by a node's own activity.
constexpr auto kOwnClasses = [] {
  std::array<std::uint8_t, kMostActivity + 1> all{};
  for (std::size_t activity = 1; activity < all.size(); ++activity) {
    all[activity] = kClasses[std::min(2 * activity, kClasses.size() - 1)];
  }
  return all;
}();

/// A sum divided by `weight` and rounded to nearest, halves up. Quotients are less than 2^16, and
/// sums are exact, so that doubles tell all quotients apart.
Int4 rounded_mean(const Double2& low, const Double2& high, double weight) {
  typedef std::int32_t Int2 __attribute__((vector_size(8)));
  // The offset makes truncation round down.
  constexpr double kOffset = 65536.0;
  const Int2 a = __builtin_convertvector(low / weight + (0.5 + kOffset), Int2);
  const Int2 b = __builtin_convertvector(high / weight + (0.5 + kOffset), Int2);
  return Int4{a[0], a[1], b[0], 0} - Int4{1 << 16, 1 << 16, 1 << 16, 0};
}

/// The same where the weight is the number of children, and sums are less than 2^19.
Int4 rounded_mean(const Int4& sum, int children) {
  const Float4 mean =
      __builtin_convertvector(sum, Float4) / static_cast<float>(children) + 65536.5f;
  return __builtin_convertvector(mean, Int4) - (1 << 16);
}

/// The class of how much there was to code around a node: `activity` with a sum of weights
/// `weight`.
int activity_class(std::int32_t activity, std::int32_t weight) {
  const std::uint64_t twice = static_cast<std::uint64_t>(2 * activity) *
                                  kActivityReciprocals[static_cast<std::size_t>(weight)] >>
                              26;
  return activity == 0 ? 0 : kClasses[std::min<std::uint64_t>(twice, kClasses.size() - 1)];
}

}  // namespace

/// Steps in the planes from a node to the neighbours that a child touches: across its faces along
/// x, y and z, and its edges along z, x and y.
struct LevelPredictor::Steps {
  std::array<std::array<std::ptrdiff_t, 6>, 8> of;

  Steps(std::ptrdiff_t stride, std::ptrdiff_t below, std::ptrdiff_t above) {
    for (std::size_t child = 0; child < 8; ++child) {
      const std::ptrdiff_t x = (child & 1) != 0 ? 1 : -1;
      const std::ptrdiff_t y = (child & 2) != 0 ? stride : -stride;
      const std::ptrdiff_t z = (child & 4) != 0 ? above : below;
      of[child] = {x, y, z, x + y, y + z, x + z};
    }
  }
};

LevelPredictor::LevelPredictor(const FrameStructure& structure, int level,
                               const PredictionRule& rule, Short4* values, std::uint8_t* contexts,
                               std::vector<Short4>& planes)
    : svo_(structure.svo()),
      level_(structure.level(level)),
      unit_(structure.has_unit_children(level)),
      weights_(structure.weights()),
      rule_(rule),
      values_(values),
      first_node_(svo_.level_begin[static_cast<std::size_t>(level)]),
      contexts_(contexts) {
  if (planes.size() < 3 * level_.plane) planes.resize(3 * structure.largest_plane());
  for (std::size_t i = 0; i < 3; ++i) planes_[i] = planes.data() + i * level_.plane;
}

void LevelPredictor::run() {
  // First as if each node had one child; the others are written over.
  const std::uint32_t end = first_node_ + static_cast<std::uint32_t>(level_.by_z.nodes.size());
  for (std::uint32_t node = first_node_; node < end; ++node) {
    values_[svo_.first_child[node]] = values_[node];
  }
  const std::size_t count = level_.by_z.slices.size() - 1;
  fill(planes_[1], 0);
  for (slice_ = 0; slice_ < count; ++slice_) {
    const bool continues = follows(slice_ + 1);
    if (continues) fill(planes_[2], slice_ + 1);
    predict_slice();
    // Moves the planes to the next slice.
    if (follows(slice_)) clear(planes_[0], slice_ - 1);
    if (!continues) {
      clear(planes_[1], slice_);
      if (slice_ + 1 < count) fill(planes_[2], slice_ + 1);
    }
    std::rotate(planes_, planes_ + 1, planes_ + 3);
  }
}

void LevelPredictor::predict_alone(std::size_t slice) {
  slice_ = slice;
  const bool below = follows(slice), above = follows(slice + 1);
  if (below) fill(planes_[0], slice - 1);
  fill(planes_[1], slice);
  if (above) fill(planes_[2], slice + 1);
  predict_slice();
  if (below) clear(planes_[0], slice - 1);
  clear(planes_[1], slice);
  if (above) clear(planes_[2], slice + 1);
}

std::span<const BranchingNode> LevelPredictor::branching() const {
  const auto& slices = level_.by_z.slices;
  const std::size_t begin = slices[slice_].branching_begin;
  return level_.by_z.branching.subspan(begin, slices[slice_ + 1].branching_begin - begin);
}

void LevelPredictor::predict_slice() {
  const Steps steps(level_.stride, planes_[0] - planes_[1], planes_[2] - planes_[1]);
  for (const BranchingNode& node : branching()) {
    contexts_[node.number - first_node_] = predict(node, planes_[1] + node.place, steps);
  }
}

/// True if a slice lies directly above the one before it.
bool LevelPredictor::follows(std::size_t slice) const {
  const auto& slices = level_.by_z.slices;
  return slice > 0 && slice + 1 < slices.size() && slices[slice].z == slices[slice - 1].z + 1;
}

void LevelPredictor::fill(Short4* plane, std::size_t slice) {
  const NodesByZ& all = level_.by_z;
  for (std::uint32_t i = all.slices[slice].begin; i < all.slices[slice + 1].begin; ++i) {
    plane[level_.place(all.at[i])] = values_[all.nodes[i]];
  }
}

void LevelPredictor::clear(Short4* plane, std::size_t slice) {
  const NodesByZ& all = level_.by_z;
  for (std::uint32_t i = all.slices[slice].begin; i < all.slices[slice + 1].begin; ++i) {
    plane[level_.place(all.at[i])] = Short4{};
  }
}

/// Sets the values of a node's children, and returns its contexts.
[[gnu::always_inline]] inline std::uint8_t LevelPredictor::predict(const BranchingNode& node,
                                                                   const Short4* at,
                                                                   const Steps& steps) {
  const Int4 value = load(*at), own = value & kComponents;
  const Int4 center = value * kParentWeight;
  std::array<Int4, 8> expected;
  int children = 0;
  std::int32_t weight = 0, activity = 0;
  Int4 least = own, most = own, sum = {};
  for (unsigned mask = node.mask; mask != 0; mask &= mask - 1) {
    const auto& step = steps.of[static_cast<std::size_t>(std::countr_zero(mask))];
    const Int4 faces = load(at[step[0]]) + load(at[step[1]]) + load(at[step[2]]);
    const Int4 edges = load(at[step[3]]) + load(at[step[4]]) + load(at[step[5]]);
    const Int4 near = center + (faces << 3) + (edges << 1) + edges;
    const auto fourth = static_cast<std::uint32_t>(near[3]);
    const auto near_weight = static_cast<std::int32_t>(fourth % kActivityUnit);
    weight += near_weight;
    activity += static_cast<std::int32_t>(fourth / kActivityUnit);
    const std::int32_t reciprocal = kReciprocals[static_cast<std::size_t>(near_weight)];
    const Int4 mean = ((near & kComponents) * reciprocal + (1 << 15)) >> 16;
    expected[static_cast<std::size_t>(children++)] = mean;
    least = min(least, mean);
    most = max(most, mean);
    sum += mean;
  }
  const Int4 range = most - least;
  const std::uint32_t first = node.first_child;
  const Int4 shift = (unit_ ? rounded_mean(own * children - sum, children)
                            : weighted_shift(own, expected.data(), first, children)) +
                     Int4{0, 0, 0, 1};
  for (int c = 0; c < children; ++c) {
    values_[first + static_cast<std::uint32_t>(c)] =
        stored_value(expected[static_cast<std::size_t>(c)] + shift);
  }
  return static_cast<std::uint8_t>(gradient_class(range) * kActivityClasses +
                                   activity_class(activity, weight));
}

/// By how much the weighted mean of the expected values is less than the node's own value.
Int4 LevelPredictor::weighted_shift(const Int4& own, const Int4* expected, std::uint32_t first,
                                    int children) const {
  const std::uint32_t* const weights = weights_ + first;
  std::uint32_t all = 0;
  for (int c = 0; c < children; ++c) all += weights[c];
  if (all < 1u << 16) {
    Int4 sum = {};
    for (int c = 0; c < children; ++c) {
      sum += (own - expected[c]) * static_cast<std::int32_t>(weights[c]);
    }
    return rounded_mean(Double2{double(sum[0]), double(sum[1])}, Double2{double(sum[2]), 0.0}, all);
  }
  std::array<std::int64_t, 3> sum{};
  for (int c = 0; c < children; ++c) {
    for (int k = 0; k < 3; ++k) {
      sum[static_cast<std::size_t>(k)] += std::int64_t{own[k] - expected[c][k]} * weights[c];
    }
  }
  return rounded_mean(Double2{static_cast<double>(sum[0]), static_cast<double>(sum[1])},
                      Double2{static_cast<double>(sum[2]), 0.0}, all);
}

/// The class of how much the expected values of a node's children vary, relative to the step.
int LevelPredictor::gradient_class(const Int4& range) const {
  const std::int32_t r = rule_.all_components ? std::max({range[0], range[1], range[2]}) : range[0];
  const std::int32_t unit = rule_.gradient_unit;
  return (8 * r >= unit) + (4 * r >= unit) + (2 * r >= unit) + (r >= unit);
}

std::size_t own_activity_class(const Short4& value) {
  return kOwnClasses[static_cast<std::size_t>(activity_of(value))];
}

void inherit_values(const Svo& svo, int level, Short4* values) {
  const std::size_t l = static_cast<std::size_t>(level);
  Short4* child = values + svo.level_begin[l + 1];
  for (std::uint32_t node = svo.level_begin[l]; node < svo.level_begin[l + 1]; ++node) {
    Short4 value = values[node];
    const int children = std::popcount(svo.masks[node]);
    value.lanes[3] = children > 1 ? std::int16_t{1} : value.lanes[3];
    // Eight are written whatever their number, and those too many are written over: a loop of
    // unknown length would be mispredicted.
    for (int c = 0; c < 8; ++c) child[c] = value;
    child += children;
  }
}

}  // namespace pointreel
