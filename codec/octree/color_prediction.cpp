#include "codec/octree/color_prediction.h"

#include <bit>

namespace pointreel {
namespace {

constexpr std::uint32_t kNone = ~std::uint32_t{0};
constexpr int kSelf = 13;

/// Of a neighbour in a 3 x 3 x 3 block: the octants that touch the middle node, and where they lie
/// in the 4 x 4 x 4 cells around its octants.
struct Touching {
  std::uint8_t mask = 0;
  std::array<std::uint8_t, 8> cell{};
};

constexpr std::array<Touching, 27> make_touching() {
  std::array<Touching, 27> all{};
  for (int place = 0; place < 27; ++place) {
    const int offset[3] = {place % 3 - 1, place / 3 % 3 - 1, place / 9 - 1};
    const int away = (offset[0] != 0) + (offset[1] != 0) + (offset[2] != 0);
    if (away == 3) continue;  // corners are no neighbours here
    for (int octant = 0; octant < 8; ++octant) {
      int cell = 0;
      bool inside = true;
      for (int axis = 2; axis >= 0; --axis) {
        const int at = 1 + 2 * offset[axis] + (octant >> axis & 1);
        inside = inside && at >= 0 && at < 4;
        cell = 4 * cell + at;
      }
      if (!inside) continue;
      all[static_cast<std::size_t>(place)].mask |= static_cast<std::uint8_t>(1 << octant);
      all[static_cast<std::size_t>(place)].cell[static_cast<std::size_t>(octant)] =
          static_cast<std::uint8_t>(cell);
    }
  }
  return all;
}

constexpr std::array<Touching, 27> kTouching = make_touching();

constexpr int kParentWeight = 18, kFaceWeight = 8, kEdgeWeight = 3;
constexpr int kMostWeight = kParentWeight + 3 * kFaceWeight + 3 * kEdgeWeight;

/// 2^16 over a sum of weights, rounded down so that a mean never exceeds what it is of.
constexpr std::array<std::int32_t, kMostWeight + 1> make_reciprocals() {
  std::array<std::int32_t, kMostWeight + 1> all{};
  for (int weight = 1; weight <= kMostWeight; ++weight) {
    all[static_cast<std::size_t>(weight)] = 65536 / weight;
  }
  return all;
}

constexpr std::array<std::int32_t, kMostWeight + 1> kReciprocals = make_reciprocals();

}  // namespace

Int4 ValueBlock::predict(int cell, int octant, std::int32_t& weight, std::int32_t& activity) const {
  const int x = octant & 1 ? 1 : -1, y = octant & 2 ? 4 : -4, z = octant & 4 ? 16 : -16;
  const auto at = [&](int where) { return load(values[static_cast<std::size_t>(where)]); };
  const Int4 faces = at(cell + x) + at(cell + y) + at(cell + z);
  const Int4 edges = at(cell + x + y) + at(cell + y + z) + at(cell + x + z);
  const Int4 sum = at(cell) * kParentWeight + faces * kFaceWeight + edges * kEdgeWeight;
  static_assert(kMostWeight < kActivityUnit);
  const std::int32_t weights = sum[3] % kActivityUnit;
  weight += weights;
  activity += sum[3] / kActivityUnit;
  const Int4 colors = sum & Int4{-1, -1, -1, 0};
  return (colors * kReciprocals[static_cast<std::size_t>(weights)] + (1 << 15)) >> 16;
}

Neighborhoods::Neighborhoods(const Svo& svo) : svo_(&svo), blocks_(svo.node_count(0)) {
  for (Block& block : blocks_) {
    block.fill(kNone);
    block[kSelf] = 0;
  }
}

void Neighborhoods::descend() {
  std::vector<Block> below(svo_->node_count(level_ + 1));
  Block* child = below.data();
  const std::size_t begin = svo_->level_begin[static_cast<std::size_t>(level_)];
  for (std::size_t i = 0; i < blocks_.size(); ++i) {
    std::array<std::uint32_t, 64> cells;
    cells.fill(kNone);
    for (std::size_t place = 0; place < 27; ++place) {
      const std::uint32_t node = blocks_[i][place];
      if (node == kNone) continue;
      std::uint32_t next = svo_->first_child[node];
      for (unsigned mask = svo_->masks[node]; mask != 0; mask &= mask - 1, ++next) {
        const auto octant = static_cast<unsigned>(std::countr_zero(mask));
        if (kTouching[place].mask >> octant & 1) cells[kTouching[place].cell[octant]] = next;
      }
    }
    for (unsigned mask = svo_->masks[begin + i]; mask != 0; mask &= mask - 1, ++child) {
      const int middle = ValueBlock::cell(std::countr_zero(mask));
      for (int place = 0; place < 27; ++place) {
        const int offset = place % 3 - 1 + 4 * (place / 3 % 3 - 1) + 16 * (place / 9 - 1);
        (*child)[static_cast<std::size_t>(place)] =
            cells[static_cast<std::size_t>(middle + offset)];
      }
    }
  }
  blocks_.swap(below);
  ++level_;
}

void Neighborhoods::load(std::uint32_t node, const std::vector<Short4>& values,
                         ValueBlock& block) const {
  block.values.fill(Short4{});
  const Block& around = blocks_[node - svo_->level_begin[static_cast<std::size_t>(level_)]];
  for (std::size_t place = 0; place < 27; ++place) {
    const std::uint32_t near = around[place];
    if (near == kNone) continue;
    const unsigned all = svo_->masks[near];
    const std::uint32_t first = svo_->first_child[near];
    for (unsigned mask = all & kTouching[place].mask; mask != 0; mask &= mask - 1) {
      const auto octant = static_cast<unsigned>(std::countr_zero(mask));
      const auto before = static_cast<unsigned>(std::popcount(all & ((1u << octant) - 1)));
      block.values[kTouching[place].cell[octant]] = values[first + before];
    }
  }
}

}  // namespace pointreel
