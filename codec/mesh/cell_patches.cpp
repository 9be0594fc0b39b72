#include "codec/mesh/cell_patches.h"

namespace pointreel {
namespace {

constexpr bool crossed(int inside, int edge) {
  const auto [a, b] = edge_corners(edge);
  return (inside >> a & 1) != (inside >> b & 1);
}

/// The edge between two corners that differ along one axis.
constexpr int edge_between(int a, int b) {
  for (int edge = 0; edge < 12; ++edge) {
    const auto [first, second] = edge_corners(edge);
    if ((first == a && second == b) || (first == b && second == a)) return edge;
  }
  return 0;
}

/// The crossed edges that belong together have the same number.
constexpr std::array<int, 12> groups_of(int inside) {
  std::array<int, 12> group{};
  for (int edge = 0; edge < 12; ++edge) group[edge] = edge;
  const auto join = [&group](int a, int b) {
    const int from = group[a], to = group[b];
    for (int& one : group) {
      if (one == from) one = to;
    }
  };
  for (int axis = 0; axis < 3; ++axis) {
    const int b = 1 << (axis + 1) % 3, c = 1 << (axis + 2) % 3;
    for (int first : {0, 1 << axis}) {
      const std::array<int, 4> ring = {first, first | b, first | b | c, first | c};
      const auto edge = [&](int i) { return edge_between(ring[i % 4], ring[(i + 1) % 4]); };
      int last = -1, crossings = 0;
      for (int i = 0; i < 4; ++i) crossings += crossed(inside, edge(i)) ? 1 : 0;
      for (int i = 0; i < 4; ++i) {
        if (crossings == 4) {
          if (inside >> ring[i] & 1) join(edge(i), edge(i + 3));
        } else if (crossed(inside, edge(i))) {
          if (last >= 0) join(last, edge(i));
          last = edge(i);
        }
      }
    }
  }
  return group;
}

constexpr CellPatches patches_of(int inside) {
  const std::array<int, 12> group = groups_of(inside);
  CellPatches patches;
  std::array<std::uint8_t, 12> number{};
  number.fill(CellPatches::kNone);
  for (int edge = 0; edge < 12; ++edge) {
    patches.of[edge] = CellPatches::kNone;
    if (!crossed(inside, edge)) continue;
    std::uint8_t& patch = number[group[edge]];
    if (patch == CellPatches::kNone) patch = patches.count++;
    patches.of[edge] = patch;
    const auto [a, b] = edge_corners(edge);
    patches.corners[patch] = static_cast<std::uint8_t>(patches.corners[patch] | 1 << a | 1 << b);
  }
  return patches;
}

}  // namespace

const CellPatches& cell_patches(std::uint8_t inside) {
  static const auto kAll = [] {
    std::array<CellPatches, 256> all{};
    for (int i = 0; i < 256; ++i) all[i] = patches_of(i);
    return all;
  }();
  return kAll[inside];
}

}  // namespace pointreel
