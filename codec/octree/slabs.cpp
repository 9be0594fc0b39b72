#include "codec/octree/slabs.h"

#include <algorithm>
#include <cstring>

namespace pointreel {
namespace {

constexpr std::size_t kLeavesOfSlab = std::size_t{1} << 19;

/// The row's coordinate along the axis of the slabs.
std::uint32_t coordinate(const RasterLevel::Row& row, int axis) {
  return axis == 1 ? row.y : row.z;
}

struct Extent {
  std::uint32_t begin, end;
  std::uint32_t size() const { return end - begin; }
};

Extent extent(const RasterLevel& level, int axis) {
  Extent extent{~0u, 0};
  for (std::size_t r = 0; r + 1 < level.rows.size(); ++r) {
    const std::uint32_t at = coordinate(level.rows[r], axis);
    extent = {std::min(extent.begin, at), std::max(extent.end, at + 1)};
  }
  return extent;
}

/// Calls visit(first node, end) for each row inside the slab, or for each row around it.
template <class Visit>
void for_each_row(const RasterLevel& level, bool in_slab, Visit visit) {
  for (std::size_t r = 0; r + 1 < level.rows.size(); ++r) {
    const std::uint32_t at = coordinate(level.rows[r], level.slab.axis);
    if ((at >= level.slab.begin && at < level.slab.end) != in_slab) continue;
    visit(level.rows[r].begin, level.rows[r + 1].begin);
  }
}

/// The weight of a leaf's probability in tenths of a decision, as kAdaptationRates implies it:
/// after n decisions, the probability is the mean of these and of the initial one, which counts as
/// 0.6.
std::int64_t weight(const Leaf& leaf) { return 10 * std::int64_t{leaf.count} + 6; }

/// The mean of leaf `i` before the phase and of all decisions that the slabs have coded with it. If
/// a slab has stopped counting, the result is limited to the range of the leaf's values before and
/// in the slabs.
Leaf merged_leaf(const Leaf& before, std::span<const std::vector<Leaf>> slabs, std::size_t i) {
  std::int64_t sum = weight(before) * before.probability, weights = weight(before);
  int count = before.count;
  std::int64_t least = before.probability, most = before.probability;
  bool counted = true;
  for (const std::vector<Leaf>& slab : slabs) {
    const Leaf& leaf = slab[i];
    sum += weight(leaf) * leaf.probability - weight(before) * before.probability;
    weights += weight(leaf) - weight(before);
    count += leaf.count - before.count;
    least = std::min<std::int64_t>(least, leaf.probability);
    most = std::max<std::int64_t>(most, leaf.probability);
    counted = counted && leaf.count < kCountLimit;
  }
  if (counted) {
    least = kLeastProbability;
    most = 65536 - kLeastProbability;
  }
  const std::int64_t probability = std::clamp(sum < 0 ? 0 : sum / weights, least, most);
  return {static_cast<std::uint16_t>(probability),
          static_cast<std::uint16_t>(std::min(count, int{kCountLimit}))};
}

}  // namespace

int default_slabs(std::size_t leaves) {
  const std::size_t slabs = leaves / kLeavesOfSlab;
  return static_cast<int>(std::clamp(slabs, std::size_t{1}, std::size_t{kMostSlabs}));
}

SlabCuts choose_cuts(const RasterLevel& level, std::span<const std::uint32_t> weights, int slabs) {
  const Extent y = extent(level, 1), z = extent(level, 2);
  const int axis = y.size() > z.size() ? 1 : 2;
  const Extent along = axis == 1 ? y : z;
  std::vector<std::uint64_t> at(along.size());
  std::uint64_t total = 0;
  for (std::size_t r = 0; r + 1 < level.rows.size(); ++r) {
    std::uint64_t& sum = at[coordinate(level.rows[r], axis) - along.begin];
    for (std::uint32_t i = level.rows[r].begin; i < level.rows[r + 1].begin; ++i) {
      sum += weights[level.rank[i]];
      total += weights[level.rank[i]];
    }
  }
  SlabCuts cuts{axis, {}};
  std::uint64_t before = 0;
  for (std::uint32_t c = 0; c < along.size(); ++c) {
    // A cut is placed in front of the first coordinate whose middle reaches the cut's share of the
    // weights, which divides them best.
    const auto number = static_cast<std::uint64_t>(cuts.begins.size()) + 1;
    const bool reached = 2 * before + at[c] >= 2 * total * number / static_cast<unsigned>(slabs);
    if (c > 0 && number < static_cast<unsigned>(slabs) && reached) {
      cuts.begins.push_back(along.begin + c);
    }
    before += at[c];
  }
  return cuts;
}

std::vector<RasterLevel> split(const RasterLevel& level, const SlabCuts& cuts) {
  std::vector<RasterLevel> slabs(cuts.begins.size() + 1);
  for (std::size_t s = 0; s < slabs.size(); ++s) {
    RasterLevel& slab = slabs[s];
    slab.level = level.level;
    slab.slab = {cuts.axis, s == 0 ? 0 : cuts.begins[s - 1],
                 s < cuts.begins.size() ? cuts.begins[s] : 1u << level.level};
    for (std::size_t r = 0; r + 1 < level.rows.size(); ++r) {
      const RasterLevel::Row& row = level.rows[r];
      const std::uint32_t at = coordinate(row, cuts.axis);
      if (at + 1 < slab.slab.begin || at > slab.slab.end) continue;
      slab.rows.push_back({row.y, row.z, static_cast<std::uint32_t>(slab.x.size())});
      for (std::uint32_t i = row.begin; i < level.rows[r + 1].begin; ++i) {
        slab.x.push_back(level.x[i]);
        slab.rank.push_back(level.rank[i]);
        slab.parents.push_back(level.parents[i]);
      }
    }
    slab.rows.push_back({0, 0, static_cast<std::uint32_t>(slab.x.size())});
    slab.masks.resize(slab.size());
    slab.around.resize(slab.size());
  }
  return slabs;
}

std::size_t count_in_slab(const RasterLevel& level) {
  std::size_t count = 0;
  for_each_row(level, true, [&](std::uint32_t begin, std::uint32_t end) { count += end - begin; });
  return count;
}

void give_masks(RasterLevel& level, ByteView masks, bool in_slab) {
  for_each_row(level, in_slab, [&](std::uint32_t begin, std::uint32_t end) {
    for (std::uint32_t i = begin; i < end; ++i) level.masks[i] = masks[level.rank[i]];
  });
}

void take_masks(const RasterLevel& level, std::span<std::uint8_t> masks) {
  for_each_row(level, true, [&](std::uint32_t begin, std::uint32_t end) {
    for (std::uint32_t i = begin; i < end; ++i) masks[level.rank[i]] = level.masks[i];
  });
}

LeafRange leaves_of_class(const ContextTables& tables, int level_class) {
  const auto first_leaf = [&](int number) -> std::size_t {
    if (number == kLevelClasses) return tables.leaves.size();
    const auto& slots = tables.slots[static_cast<std::size_t>(number)];
    return tables.cells[slots.front().first_cell].first_leaf;
  };
  return {first_leaf(level_class), first_leaf(level_class + 1)};
}

void merge_leaves(std::span<const std::vector<Leaf>> slabs, LeafRange range,
                  std::vector<Leaf>& leaves) {
  constexpr std::size_t kBlock = 16;
  for (std::size_t block = range.begin; block < range.end; block += kBlock) {
    const std::size_t end = std::min(block + kBlock, range.end);
    // Most leaves were not used in the phase.
    bool same = true;
    for (const std::vector<Leaf>& slab : slabs) {
      same = same && std::memcmp(slab.data() + block, leaves.data() + block,
                                 (end - block) * sizeof(Leaf)) == 0;
    }
    if (same) continue;
    for (std::size_t i = block; i < end; ++i) leaves[i] = merged_leaf(leaves[i], slabs, i);
  }
}

}  // namespace pointreel
