#include "codec/octree/frame_structure.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <initializer_list>

namespace pointreel {
namespace {

constexpr std::uint32_t kMostNodeWeight = std::uint32_t{1} << 26;

/// Numbers are read and written in fours and eights.
constexpr std::size_t kSpareNumbers = 8;

/// A plane that is not larger than this may always be used, and one that has no more cells for each
/// node of its level.
constexpr std::uint64_t kSmallPlane = 1 << 16, kCellsOfNode = 2;

/// So many columns or rows, and twice as many, can be numbered with 16 bits.
constexpr std::uint32_t kMostColumns = 1 << 15;

bool branches(unsigned mask) { return (mask & (mask - 1)) != 0; }

typedef std::uint32_t Uint4 __attribute__((vector_size(16)));
typedef std::uint16_t Ushort8 __attribute__((vector_size(16)));

template <class Vector>
Vector load_from(const std::uint32_t* at) {
  Vector v;
  std::memcpy(&v, at, sizeof(v));
  return v;
}

void store(std::uint32_t* at, const Uint4& four) { std::memcpy(at, &four, sizeof(four)); }

/// For each half of a mask, the children that a node has there, one after the other: what is added
/// to twice the node's x and y.
constexpr auto kHalves = [] {
  std::array<std::array<std::uint32_t, 4>, 16> all{};
  for (unsigned mask = 0; mask < 16; ++mask) {
    std::size_t count = 0;
    for (unsigned child = 0; child < 4; ++child) {
      if ((mask >> child & 1) != 0) all[mask][count++] = (child & 1) | (child >> 1) << 16;
    }
  }
  return all;
}();

/// Selects the first of eight numbers.
constexpr auto kFirst = [] {
  std::array<std::array<std::uint32_t, 8>, 9> all{};
  for (std::size_t count = 0; count <= 8; ++count) {
    for (std::size_t i = 0; i < count; ++i) all[count][i] = ~0u;
  }
  return all;
}();

/// The least and the largest x and y of a level's nodes.
struct Bounds {
  std::uint32_t least_x, least_y, most_x, most_y;
};

Bounds bounds_of(std::span<const std::uint32_t> at) {
  Ushort8 least = ~Ushort8{}, most = {};
  const auto add = [&](const Ushort8& v) {
    least = v < least ? v : least;
    most = v > most ? v : most;
  };
  std::size_t i = 0;
  for (; i + 4 <= at.size(); i += 4) add(load_from<Ushort8>(&at[i]));
  for (; i < at.size(); ++i) {
    const Uint4 same = Uint4{} + at[i];
    add(reinterpret_cast<Ushort8>(same));
  }
  const auto reduced = [](const Ushort8& v, int lane, auto&& choose) -> std::uint32_t {
    return choose({v[lane], v[lane + 2], v[lane + 4], v[lane + 6]});
  };
  const auto min = [](std::initializer_list<std::uint16_t> of) { return std::min(of); };
  const auto max = [](std::initializer_list<std::uint16_t> of) { return std::max(of); };
  return {reduced(least, 0, min), reduced(least, 1, min), reduced(most, 0, max),
          reduced(most, 1, max)};
}

}  // namespace

FrameStructure::FrameStructure(const Svo& svo, std::vector<int> layer_ends, LevelSet ordered)
    : svo_(svo),
      layer_ends_(std::move(layer_ends)),
      levels_(static_cast<std::size_t>(svo.depth)),
      slices_(levels_.size()),
      branching_by_z_(levels_.size()) {
  const std::size_t count = svo.internal_count();
  for (Numbers* numbers : {&weights_, &branching_, &nodes_, &at_}) {
    *numbers = std::make_unique_for_overwrite<std::uint32_t[]>(count + kSpareNumbers);
  }
  if (count == 0) return;
  find_weights();
  find_branching();
  order_by_z(ordered);
}

bool FrameStructure::has_unit_children(int level) const {
  return std::find(layer_ends_.begin(), layer_ends_.end(), level + 1) != layer_ends_.end();
}

void FrameStructure::find_weights() {
  for (int level = svo_.depth; level-- > 0;) {
    const std::size_t l = static_cast<std::size_t>(level);
    const std::uint32_t begin = svo_.level_begin[l], end = svo_.level_begin[l + 1];
    if (has_unit_children(level)) {
      for (std::uint32_t node = begin; node < end; ++node) {
        weights_[node] = static_cast<std::uint32_t>(std::popcount(svo_.masks[node]));
      }
      continue;
    }
    // Eight weights are read whatever the number of children: a loop of unknown length would be
    // mispredicted.
    const std::uint32_t* child = weights_.get() + end;
    for (std::uint32_t node = begin; node < end; ++node) {
      const auto children = static_cast<std::size_t>(std::popcount(svo_.masks[node]));
      const std::uint32_t* const first = kFirst[children].data();
      const Uint4 sum = (load_from<Uint4>(child) & load_from<Uint4>(first)) +
                        (load_from<Uint4>(child + 4) & load_from<Uint4>(first + 4));
      weights_[node] = std::min(sum[0] + sum[1] + sum[2] + sum[3], kMostNodeWeight);
      child += children;
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

void FrameStructure::order_by_z(LevelSet ordered) {
  nodes_[0] = at_[0] = 0;
  slices_[0] = {{0, 0, 0}, {0, 1, 0}};
  const int last = std::min(svo_.depth, static_cast<int>(std::bit_width(ordered))) - 1;
  for (int level = 1; level <= last; ++level) {
    descend(level - 1);
    find_plane(level);
    // The planes of finer levels are larger still.
    if (!levels_[static_cast<std::size_t>(level)].predictable) return;
    if ((ordered >> level & 1) != 0) list_branching(level);
  }
}

/// Finds the nodes of the next level, their slices and where they are. No branch depends on a mask:
/// four children are written whatever the mask, and those too many are written over.
void FrameStructure::descend(int level) {
  const std::size_t l = static_cast<std::size_t>(level);
  const std::uint32_t* const parents = nodes_.get() + svo_.level_begin[l];
  const std::uint32_t* const parents_at = at_.get() + svo_.level_begin[l];
  std::uint32_t* const nodes = nodes_.get() + svo_.level_begin[l + 1];
  std::uint32_t* const at = at_.get() + svo_.level_begin[l + 1];
  const std::uint32_t origin = levels_[l].least_x | levels_[l].least_y << 16;
  const auto& slices = slices_[l];
  auto& slices_below = slices_[l + 1];
  slices_below.reserve(std::min<std::size_t>(2 * slices.size(), svo_.node_count(level + 1) + 1));
  std::uint32_t out = 0;
  for (std::size_t s = 0; s + 1 < slices.size(); ++s) {
    for (int half = 0; half < 2; ++half) {
      const std::uint32_t begin = out;
      for (std::uint32_t i = slices[s].begin; i < slices[s + 1].begin; ++i) {
        const std::uint32_t node = parents[i];
        const unsigned mask = svo_.masks[node];
        const unsigned part = half == 0 ? mask & 15 : mask >> 4;
        const int before = half == 0 ? 0 : std::popcount(mask & 15);
        const std::uint32_t first = svo_.first_child[node] + static_cast<std::uint32_t>(before);
        store(at + out, load_from<Uint4>(kHalves[part].data()) + 2 * (parents_at[i] - origin));
        store(nodes + out, Uint4{0, 1, 2, 3} + first);
        out += static_cast<std::uint32_t>(std::popcount(part));
      }
      const std::uint32_t z = 2 * slices[s].z + static_cast<std::uint32_t>(half);
      if (out > begin) slices_below.push_back({z, begin, 0});
    }
  }
  slices_below.push_back({0, out, 0});
}

/// Finds how large the planes of a level are.
void FrameStructure::find_plane(int level) {
  const std::size_t l = static_cast<std::size_t>(level);
  LevelStructure& of = levels_[l];
  const std::size_t count = svo_.node_count(level);
  const Bounds bounds = bounds_of({at_.get() + svo_.level_begin[l], count});
  const std::uint32_t columns = bounds.most_x - bounds.least_x + 1;
  const std::uint32_t rows = bounds.most_y - bounds.least_y + 1;
  const std::uint64_t plane = std::uint64_t{columns + 2} * (rows + 2);
  of.predictable = plane <= std::max(kSmallPlane, kCellsOfNode * count) &&
                   std::max(columns, rows) <= kMostColumns;
  if (!of.predictable) return;
  of.least_x = bounds.least_x;
  of.least_y = bounds.least_y;
  of.stride = columns + 2;
  of.plane = static_cast<std::size_t>(plane);
}

/// Finds the nodes with two children or more of a level in the order of NodesByZ.
void FrameStructure::list_branching(int level) {
  const std::size_t l = static_cast<std::size_t>(level);
  LevelStructure& of = levels_[l];
  const std::size_t count = svo_.node_count(level), begin = svo_.level_begin[l];
  largest_plane_ = std::max(largest_plane_, of.plane);
  auto& slices = slices_[l];
  auto& branching = branching_by_z_[l];
  branching = std::make_unique_for_overwrite<BranchingNode[]>(of.branching.size() + 1);
  std::size_t out = 0;
  for (std::size_t s = 0; s + 1 < slices.size(); ++s) {
    slices[s].branching_begin = static_cast<std::uint32_t>(out);
    for (std::uint32_t i = slices[s].begin; i < slices[s + 1].begin; ++i) {
      const std::uint32_t node = nodes_[begin + i], mask = svo_.masks[node];
      branching[out] = {node, svo_.first_child[node], of.place(at_[begin + i]), mask};
      out += branches(mask);
    }
  }
  slices.back().branching_begin = static_cast<std::uint32_t>(out);
  of.by_z = {
      slices, {nodes_.get() + begin, count}, {at_.get() + begin, count}, {branching.get(), out}};
}

}  // namespace pointreel
