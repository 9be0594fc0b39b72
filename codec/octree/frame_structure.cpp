#include "codec/octree/frame_structure.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>

#include "codec/octree/int4.h"

namespace pointreel {
namespace {

constexpr std::uint32_t kMostWeight = std::uint32_t{1} << 26;

/// Numbers are read and written in fours and eights.
constexpr std::size_t kRoom = 8;

/// A plane that is not larger than this may always be used, and one that has no more cells for each
/// node of its level.
constexpr std::uint64_t kSmallPlane = 1 << 16, kCellsOfNode = 2;

bool branches(unsigned mask) { return (mask & (mask - 1)) != 0; }

/// The children that a node has in one half, lower or upper, one after the other: how much is added
/// to twice the node's coordinates.
struct HalfOfChildren {
  Int4 x, y;
};

constexpr int kHalfMasks = 16;

const std::array<HalfOfChildren, kHalfMasks>& halves() {
  static const auto all = [] {
    std::array<HalfOfChildren, kHalfMasks> made{};
    for (unsigned mask = 0; mask < kHalfMasks; ++mask) {
      int count = 0;
      for (int child = 0; child < 4; ++child) {
        if ((mask >> child & 1) == 0) continue;
        made[mask].x[count] = child & 1;
        made[mask].y[count] = child >> 1;
        ++count;
      }
    }
    return made;
  }();
  return all;
}

void store(std::uint32_t* at, const Int4& four) { std::memcpy(at, &four, sizeof(four)); }

}  // namespace

/// The coordinates of a level's nodes in the order of NodesByZ.
struct FrameStructure::Places {
  /// Four are written at once, so that there is room for three more.
  explicit Places(std::size_t count)
      : x(std::make_unique_for_overwrite<std::uint32_t[]>(count + 4)),
        y(std::make_unique_for_overwrite<std::uint32_t[]>(count + 4)) {}
  Numbers x, y;
};

FrameStructure::FrameStructure(const Svo& svo, std::vector<int> layer_ends)
    : svo_(svo),
      layer_ends_(std::move(layer_ends)),
      levels_(static_cast<std::size_t>(svo.depth)),
      slices_(levels_.size()),
      branching_by_z_(levels_.size()) {
  const std::size_t count = svo.internal_count();
  for (Numbers* numbers : {&weights_, &branching_, &nodes_, &places_}) {
    *numbers = std::make_unique_for_overwrite<std::uint32_t[]>(count + kRoom);
  }
  if (count == 0) return;
  find_weights();
  find_branching();
  order_by_z();
}

bool FrameStructure::has_unit_children(int level) const {
  return std::find(layer_ends_.begin(), layer_ends_.end(), level + 1) != layer_ends_.end();
}

void FrameStructure::find_weights() {
  for (int level = svo_.depth; level-- > 0;) {
    const std::size_t l = static_cast<std::size_t>(level);
    const bool unit = has_unit_children(level);
    const std::uint32_t* child = weights_.get() + svo_.level_begin[l + 1];
    for (std::uint32_t node = svo_.level_begin[l]; node < svo_.level_begin[l + 1]; ++node) {
      const int children = std::popcount(svo_.masks[node]);
      std::uint32_t sum = static_cast<std::uint32_t>(children);
      if (!unit) {
        sum = 0;
        for (int c = 0; c < children; ++c) sum += *child++;
      }
      weights_[node] = std::min(sum, kMostWeight);
    }
  }
}

void FrameStructure::find_branching() {
  std::uint32_t* out = branching_.get();
  for (int level = 0; level < svo_.depth; ++level) {
    const std::size_t l = static_cast<std::size_t>(level);
    std::uint32_t* const begin = out;
    for (std::uint32_t node = svo_.level_begin[l]; node < svo_.level_begin[l + 1]; ++node) {
      *out = node;
      out += branches(svo_.masks[node]);
    }
    levels_[l].branching = {begin, out};
  }
}

void FrameStructure::order_by_z() {
  Places places(1);
  places.x[0] = places.y[0] = nodes_[0] = 0;
  slices_[0] = {{0, 0, 0}, {0, 1, 0}};
  for (int level = 1; level < svo_.depth; ++level) {
    Places below(svo_.node_count(level));
    descend(level - 1, places, below);
    place(level, below);
    // The planes of finer levels are larger still.
    if (!levels_[static_cast<std::size_t>(level)].predictable) return;
    std::swap(places, below);
  }
}

/// Finds the nodes of the next level, their slices and their coordinates. No branch depends on a
/// mask: four children are written whatever the mask, and those too many are written over.
void FrameStructure::descend(int level, const Places& above, Places& below) {
  const std::size_t l = static_cast<std::size_t>(level);
  const std::uint32_t* const parents = nodes_.get() + svo_.level_begin[l];
  std::uint32_t* const nodes = nodes_.get() + svo_.level_begin[l + 1];
  const auto& slices = slices_[l];
  auto& slices_below = slices_[l + 1];
  slices_below.reserve(std::min<std::size_t>(2 * slices.size(), svo_.node_count(level + 1) + 1));
  const auto& half_of = halves();
  std::uint32_t out = 0;
  for (std::size_t s = 0; s + 1 < slices.size(); ++s) {
    for (int half = 0; half < 2; ++half) {
      const std::uint32_t begin = out;
      for (std::uint32_t i = slices[s].begin; i < slices[s + 1].begin; ++i) {
        const std::uint32_t node = parents[i];
        const unsigned mask = svo_.masks[node];
        const unsigned part = half == 0 ? mask & 15 : mask >> 4;
        const int before = half == 0 ? 0 : std::popcount(mask & 15);
        const auto first = static_cast<std::int32_t>(svo_.first_child[node]) + before;
        store(below.x.get() + out, static_cast<std::int32_t>(2 * above.x[i]) + half_of[part].x);
        store(below.y.get() + out, static_cast<std::int32_t>(2 * above.y[i]) + half_of[part].y);
        store(nodes + out, first + Int4{0, 1, 2, 3});
        out += static_cast<std::uint32_t>(std::popcount(part));
      }
      const std::uint32_t z = 2 * slices[s].z + static_cast<std::uint32_t>(half);
      if (out > begin) slices_below.push_back({z, begin, 0});
    }
  }
  slices_below.push_back({0, out, 0});
}

/// Finds where the nodes stand in the planes of a level.
void FrameStructure::place(int level, const Places& places) {
  const std::size_t l = static_cast<std::size_t>(level);
  LevelStructure& structure = levels_[l];
  const std::size_t count = svo_.node_count(level), begin = svo_.level_begin[l];
  std::uint32_t least_x = ~0u, least_y = ~0u, most_x = 0, most_y = 0;
  for (std::size_t i = 0; i < count; ++i) {
    least_x = std::min(least_x, places.x[i]);
    most_x = std::max(most_x, places.x[i]);
    least_y = std::min(least_y, places.y[i]);
    most_y = std::max(most_y, places.y[i]);
  }
  const std::uint32_t stride = most_x - least_x + 3;
  const std::uint64_t plane = std::uint64_t{stride} * (most_y - least_y + 3);
  structure.predictable = plane <= std::max(kSmallPlane, kCellsOfNode * count);
  if (!structure.predictable) return;
  structure.stride = stride;
  structure.plane = static_cast<std::size_t>(plane);
  largest_plane_ = std::max(largest_plane_, structure.plane);
  auto& slices = slices_[l];
  auto& branching = branching_by_z_[l];
  branching.resize(structure.branching.size() + 1);
  std::size_t out = 0;
  for (std::size_t s = 0; s + 1 < slices.size(); ++s) {
    slices[s].branching_begin = static_cast<std::uint32_t>(out);
    for (std::uint32_t i = slices[s].begin; i < slices[s + 1].begin; ++i) {
      const std::uint32_t node = nodes_[begin + i], mask = svo_.masks[node];
      const std::uint32_t at = (places.y[i] - least_y + 1) * stride + places.x[i] - least_x + 1;
      places_[begin + i] = at;
      branching[out] = {node, svo_.first_child[node], at, mask};
      out += branches(mask);
    }
  }
  slices.back().branching_begin = static_cast<std::uint32_t>(out);
  structure.by_z = {slices,
                    {nodes_.get() + begin, count},
                    {places_.get() + begin, count},
                    {branching.data(), out}};
}

}  // namespace pointreel
