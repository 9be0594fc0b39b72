#include "codec/octree/slice_level.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>

namespace pointreel {
namespace {

typedef std::uint32_t Uint4 __attribute__((vector_size(16)));

/// For each half of a mask, its children in order: their x, y and numbers. Four are written for
/// each half of a node, whatever its mask. Those that it does not have come last, and are written
/// over.
struct Children {
  std::array<std::array<std::uint32_t, 4>, 16> x{}, y{}, number{};
};
constexpr Children kChildren = [] {
  Children all;
  for (std::size_t mask = 0; mask < 16; ++mask) {
    std::size_t count = 0;
    for (std::uint32_t child = 0; child < 4; ++child) {
      if ((mask >> child & 1u) == 0) continue;
      all.x[mask][count] = child & 1u;
      all.y[mask][count] = child >> 1;
      all.number[mask][count++] = child << 29;
    }
  }
  return all;
}();

void put(std::uint32_t* to, std::uint32_t base, const std::array<std::uint32_t, 4>& offsets) {
  Uint4 values;
  std::memcpy(&values, offsets.data(), sizeof(values));
  values += base;
  std::memcpy(to, &values, sizeof(values));
}

void resize(SliceLevel& level, std::size_t nodes) {
  for (auto* values : {&level.x, &level.y, &level.rank, &level.inherited, &level.parents}) {
    values->resize(nodes + SliceLevel::kSpare);
  }
  level.masks.assign(nodes, 0);
}

}  // namespace

SliceLevel root_level() {
  SliceLevel root;
  root.slices = {{0, 0}, {0, 1}};
  resize(root, 1);
  return root;
}

std::size_t slice_from(const SliceLevel& level, std::uint32_t z) {
  const auto first = level.slices.begin(), last = level.slices.end() - 1;
  const auto found = std::lower_bound(
      first, last, z, [](const SliceLevel::Slice& s, std::uint32_t value) { return s.z < value; });
  return static_cast<std::size_t>(found - first);
}

void expand(const SliceLevel& level, std::span<const std::uint32_t> first_child,
            std::size_t child_count, SliceLevel& children) {
  static constexpr std::array<std::uint32_t, 4> kCount = {0, 1, 2, 3};
  children.level = level.level + 1;
  children.slices.clear();
  resize(children, child_count);
  std::uint32_t next = 0;
  for (std::size_t slice = 0; slice < level.slice_count(); ++slice) {
    for (std::uint32_t half = 0; half < 2; ++half) {
      const std::uint32_t begin = next;
      for (std::uint32_t i = level.slices[slice].begin; i < level.slices[slice + 1].begin; ++i) {
        const std::uint32_t mask = level.masks[i], part = mask >> (4 * half) & 15u;
        const std::uint32_t before = half == 0 ? 0u : mask & 15u;
        put(&children.x[next], 2 * level.x[i], kChildren.x[part]);
        put(&children.y[next], 2 * level.y[i], kChildren.y[part]);
        put(&children.rank[next],
            first_child[level.rank[i]] + static_cast<std::uint32_t>(std::popcount(before)), kCount);
        put(&children.parents[next], level.inherited[i] | half << 31, kChildren.number[part]);
        next += static_cast<std::uint32_t>(std::popcount(part));
      }
      if (next > begin) children.slices.push_back({2 * level.slices[slice].z + half, begin});
    }
  }
  children.slices.push_back({0, next});
}

}  // namespace pointreel
