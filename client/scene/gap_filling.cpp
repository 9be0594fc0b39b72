#include "client/scene/gap_filling.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <span>
#include <utility>

#include "common/octree/build.h"

namespace pointreel {
namespace {

/// How many leaves a parent has on a surface whose gaps are worth filling. A closed surface has
/// four; random points, two to a cell, have 3.5. Below the least, gaps are many cells wide.
constexpr double kClosedGrowth = 3.4, kLeastGrowth = 1.7;
/// With so few points in a leaf, and more than the one that voxelised input has, random points
/// leave some cells empty even where the tree grows like this.
constexpr double kRandomGrowth = 3.9, kLeastRandomPoints = 1.5, kMostRandomPoints = 8.0;
/// If the leaves are coarser than the delta rule wants them, for a view from afar, the gaps are as
/// wide as before but have fewer cells.
constexpr double kCoarsePointsPerLeaf = 5.0;
constexpr int kWidest = 3, kWidestOfCoarse = 1;

/// A node two levels above the leaves and its 4^3 cells: bit x + 4 y + 16 z.
using Cells = std::uint64_t;

constexpr unsigned cell_number(int x, int y, int z) {
  return static_cast<unsigned>(x + 4 * y + 16 * z);
}

/// All cells of a node's first child. Those of the next child are two further along an axis.
constexpr Cells kChild = 0x330033;
constexpr unsigned child_shift(unsigned child) {
  return cell_number(2 * static_cast<int>(child & 1u), 2 * static_cast<int>(child >> 1 & 1u),
                     2 * static_cast<int>(child >> 2));
}

/// The cells of that child that its mask names, and the mask from the cells.
constexpr auto kSpread = [] {
  std::array<Cells, 256> spread{};
  for (unsigned mask = 0; mask < 256; ++mask) {
    for (int c = 0; c < 8; ++c) {
      if (mask >> c & 1u) spread[mask] |= Cells{1} << cell_number(c & 1, c >> 1 & 1, c >> 2);
    }
  }
  return spread;
}();
constexpr unsigned mask_of(Cells cells) {
  return static_cast<unsigned>((cells & 3u) | (cells >> 4 & 3u) << 2 | (cells >> 16 & 3u) << 4 |
                               (cells >> 20 & 3u) << 6);
}

/// The position of each cell in the order of the leaves, and the cells in that order.
constexpr auto kOrder = [] {
  std::array<std::uint8_t, 64> order{};
  for (unsigned i = 0; i < 64; ++i) {
    const unsigned cell = child_shift(i >> 3) + child_shift(i & 7u) / 2;
    order[cell] = static_cast<std::uint8_t>(i);
  }
  return order;
}();
constexpr Cells in_order(Cells cells) {
  Cells ordered = 0;
  for (unsigned child = 0; child < 8; ++child)
    ordered |= Cells{mask_of(cells >> child_shift(child))} << 8 * child;
  return ordered;
}

/// The numbers of a node and of the nodes around it on its level, at 1 + x + 3 (1 + y) + 9 (1 + z)
/// with each coordinate from -1 to 1. Where there is no node, a number beyond the last.
using Around = std::array<std::uint32_t, 27>;
constexpr std::size_t kMiddle = 13;

/// For each cell of a brick, the cell that lies `distance` further along a line. Together these are
/// parts of up to eight bricks around it, moved.
struct Move {
  struct Part {
    std::uint8_t brick;  ///< its index in Around
    std::int8_t ahead;   ///< cell i is seen from cell i - ahead, if the mask has that
    Cells seen_from;
  };
  std::array<Part, 8> parts{};
  unsigned count = 0;

  constexpr Move() = default;
  constexpr Move(const std::array<int, 3>& line, int distance) {
    for (unsigned crossing = 0; crossing < 8; ++crossing) {
      // For each axis, whether the cells that are seen lie in the next brick.
      std::array<int, 3> step{}, brick{};
      bool possible = true;
      for (unsigned axis = 0; axis < 3; ++axis) {
        const bool crosses = (crossing >> axis & 1u) != 0;
        possible = possible && (line[axis] != 0 || !crosses);
        brick[axis] = crosses ? line[axis] : 0;
        step[axis] = distance * line[axis] - 4 * brick[axis];
      }
      if (!possible) continue;
      Part part{static_cast<std::uint8_t>(1 + brick[0] + 3 * (1 + brick[1]) + 9 * (1 + brick[2])),
                static_cast<std::int8_t>(step[0] + 4 * step[1] + 16 * step[2]), 0};
      for (int z = 0; z < 4; ++z) {
        for (int y = 0; y < 4; ++y) {
          for (int x = 0; x < 4; ++x) {
            const auto inside = [](int c) { return c >= 0 && c < 4; };
            if (inside(x + step[0]) && inside(y + step[1]) && inside(z + step[2]))
              part.seen_from |= Cells{1} << cell_number(x, y, z);
          }
        }
      }
      parts[count++] = part;
    }
  }
};

/// Moves the cells of a part's brick to the cells that they are seen from. Bits that are shifted
/// out come in on the other side, where the mask drops them.
constexpr Cells seen(const Move::Part& part, Cells cells) {
  const auto ahead = static_cast<unsigned>(part.ahead) & 63u;
  return (cells >> ahead | cells << (-ahead & 63u)) & part.seen_from;
}

/// The 13 lines, each in both directions, by distances of 1 to kWidest.
constexpr std::size_t kLines = 13;
struct Line {
  std::array<std::array<Move, kWidest>, 2> moves;  ///< forwards, backwards
};
constexpr auto kMoves = [] {
  std::array<Line, kLines> lines{};
  for (std::size_t i = 0; i < kLines; ++i) {
    const int n = static_cast<int>(kMiddle + 1 + i);
    for (int sign : {1, -1}) {
      const std::array<int, 3> line = {sign * (n % 3 - 1), sign * (n / 3 % 3 - 1),
                                       sign * (n / 9 - 1)};
      for (int distance = 1; distance <= kWidest; ++distance) {
        lines[i].moves[sign > 0 ? 0 : 1][static_cast<std::size_t>(distance - 1)] =
            Move(line, distance);
      }
    }
  }
  return lines;
}();

/// The nodes around each node of a level. They follow from those of the level above.
std::vector<Around> nodes_around(const Svo& svo, int level) {
  std::vector<Around> around(1), below;
  around[0].fill(1);
  around[0][kMiddle] = 0;
  for (int l = 0; l < level; ++l) {
    const std::uint32_t first = svo.level_begin[static_cast<std::size_t>(l)];
    const std::uint32_t first_below = svo.level_begin[static_cast<std::size_t>(l) + 1];
    const std::uint32_t count = svo.node_count(l), none = svo.node_count(l + 1);
    below.resize(none);
    for (std::uint32_t i = 0; i < count; ++i) {
      std::uint32_t child_number = svo.first_child[first + i] - first_below;
      for (unsigned mask = svo.masks[first + i]; mask != 0; mask &= mask - 1, ++child_number) {
        const int child = std::countr_zero(mask);
        for (int n = 0; n < 27; ++n) {
          // Counted in cells of the parent's 2^3, with one more on each side.
          const int x = (child & 1) + n % 3 - 1, y = (child >> 1 & 1) + n / 3 % 3 - 1,
                    z = (child >> 2) + n / 9 - 1;
          const int parent = 1 + (x >> 1) + 3 * (1 + (y >> 1)) + 9 * (1 + (z >> 1));
          const std::uint32_t in = around[i][static_cast<std::size_t>(parent)];
          const unsigned siblings = in < count ? svo.masks[first + in] : 0u;
          const unsigned bit = 1u << ((x & 1) | (y & 1) << 1 | (z & 1) << 2);
          below[child_number][static_cast<std::size_t>(n)] =
              (siblings & bit) == 0
                  ? none
                  : svo.first_child[first + in] - first_below +
                        static_cast<std::uint32_t>(std::popcount(siblings & (bit - 1u)));
        }
      }
    }
    std::swap(around, below);
  }
  return around;
}

/// The empty cells between two occupied ones that are no more than `widest` cells apart.
Cells cells_between(const std::array<Cells, 27>& there, int widest) {
  const auto see = [&there](const Move& move) {
    Cells cells = 0;
    for (unsigned p = 0; p < move.count; ++p) {
      const Move::Part& part = move.parts[p];
      cells |= seen(part, there[part.brick]);
    }
    return cells;
  };
  Cells between = 0;
  for (const Line& line : kMoves) {
    // Cells within a distance backwards: the nearer the leaf ahead, the farther the leaf behind may
    // be.
    std::array<Cells, kWidest> behind{};
    for (std::size_t i = 0; i < static_cast<std::size_t>(widest); ++i)
      behind[i] = see(line.moves[1][i]) | (i > 0 ? behind[i - 1] : 0);
    for (std::size_t i = 0; i < static_cast<std::size_t>(widest); ++i)
      between |= see(line.moves[0][i]) & behind[static_cast<std::size_t>(widest) - 1 - i];
  }
  return between & ~there[kMiddle];
}

/// The cells of a node two levels above the leaves.
struct Brick {
  Cells before = 0, after = 0;   ///< without and with the cells that fill gaps
  Cells ordered = 0;             ///< `after` in the order of the leaves
  std::uint32_t first_leaf = 0;  ///< its index among the leaves of the new tree
};

std::vector<Brick> find_bricks(const Svo& svo, const std::vector<Around>& around, int widest) {
  const std::uint32_t first = svo.level_begin[static_cast<std::size_t>(svo.depth) - 2];
  std::vector<Cells> cells(around.size() + 1, 0);  // the last stands for a missing brick
  for (std::size_t i = 0; i < around.size(); ++i) {
    std::uint32_t child = svo.first_child[first + i];
    for (unsigned mask = svo.masks[first + i]; mask != 0; mask &= mask - 1, ++child) {
      const auto octant = static_cast<unsigned>(std::countr_zero(mask));
      cells[i] |= kSpread[svo.masks[child]] << child_shift(octant);
    }
  }
  std::vector<Brick> bricks(around.size());
  std::uint32_t leaf = 0;
  for (std::size_t i = 0; i < bricks.size(); ++i) {
    std::array<Cells, 27> there;
    for (std::size_t n = 0; n < 27; ++n) there[n] = cells[around[i][n]];
    const Cells after = cells[i] | cells_between(there, widest);
    bricks[i] = {cells[i], after, in_order(after), leaf};
    leaf += static_cast<std::uint32_t>(std::popcount(after));
  }
  return bricks;
}

/// The tree with these leaves, and which of its nodes are new.
std::pair<Svo, FilledNodes> tree_of(const Svo& before, std::span<const Brick> bricks) {
  Svo svo;
  svo.cube = before.cube;
  svo.depth = before.depth;
  const std::uint32_t first = before.level_begin[static_cast<std::size_t>(svo.depth) - 2];
  svo.masks.assign(before.masks.begin(), before.masks.begin() + first);
  FilledNodes filled(first + bricks.size());
  std::vector<std::uint8_t> last;
  for (const Brick& brick : bricks) {
    unsigned children = 0;
    for (unsigned child = 0; child < 8; ++child) {
      const Cells cells = kChild << child_shift(child);
      if ((brick.after & cells) == 0) continue;
      children |= 1u << child;
      last.push_back(static_cast<std::uint8_t>(mask_of(brick.after >> child_shift(child))));
      filled.push_back((brick.before & cells) == 0);
    }
    svo.masks.push_back(static_cast<std::uint8_t>(children));
  }
  for (const Brick& brick : bricks) {
    const Cells before_it = in_order(brick.before);
    for (Cells left = brick.ordered; left != 0; left &= left - 1)
      filled.push_back((before_it >> std::countr_zero(left) & 1u) == 0);
  }
  svo.masks.insert(svo.masks.end(), last.begin(), last.end());
  index_svo(svo, true);
  return {std::move(svo), std::move(filled)};
}

glm::u16vec3 mean_of(const glm::ivec3& sum, int count, glm::u16vec3 /*of colours*/) {
  return glm::u16vec3((sum + count / 2) / count);
}
glm::i16vec3 mean_of(const glm::ivec3& sum, int /*count*/, glm::i16vec3 /*of normals*/) {
  const float length = glm::length(glm::vec3(sum));
  return length > 0.0f ? glm::i16vec3(glm::round(glm::vec3(sum) * (32767.0f / length)))
                       : glm::i16vec3(0);
}

std::uint32_t leaf_at(const Brick& brick, unsigned cell) {
  const Cells lower = (Cells{1} << kOrder[cell]) - 1;
  return brick.first_leaf + static_cast<std::uint32_t>(std::popcount(brick.ordered & lower));
}

/// Gives the `wanted` leaves of a brick the means of the `known` leaves that touch them. Returns
/// those that any touches.
template <class Value>
Cells fill_cells(std::span<Value> leaves, std::span<const Brick> bricks, const Around& around,
                 std::span<const Cells> known, Cells wanted, const Brick& brick) {
  std::array<glm::ivec3, 64> sums{};
  std::array<int, 64> counts{};
  Cells found = 0;
  for (const Line& line : kMoves) {
    for (const auto& direction : line.moves) {
      const Move& beside = direction[0];
      for (unsigned p = 0; p < beside.count; ++p) {
        const Move::Part& part = beside.parts[p];
        const std::uint32_t from = around[part.brick];
        Cells cells = seen(part, known[from]) & wanted;
        found |= cells;
        for (; cells != 0; cells &= cells - 1) {
          const int cell = std::countr_zero(cells);
          const auto touching = static_cast<unsigned>(cell + part.ahead);
          sums[static_cast<std::size_t>(cell)] +=
              glm::ivec3(leaves[leaf_at(bricks[from], touching)]);
          ++counts[static_cast<std::size_t>(cell)];
        }
      }
    }
  }
  for (Cells cells = found; cells != 0; cells &= cells - 1) {
    const auto cell = static_cast<unsigned>(std::countr_zero(cells));
    leaves[leaf_at(brick, cell)] = mean_of(sums[cell], counts[cell], Value{});
  }
  return found;
}

/// Gives new leaves values, outwards from the old ones. Leaves that are not reached that way get
/// the value of their brick.
template <class Value>
void fill_leaves(std::span<Value> leaves, std::span<const Value> brick_values,
                 std::span<const Brick> bricks, const std::vector<Around>& around) {
  std::vector<Cells> known(bricks.size() + 1, 0), found(bricks.size());
  for (std::size_t i = 0; i < bricks.size(); ++i) known[i] = bricks[i].before;
  for (bool more = true; more;) {
    more = false;
    for (std::size_t i = 0; i < bricks.size(); ++i) {
      const Cells wanted = bricks[i].after & ~known[i];
      found[i] = wanted == 0 ? 0 : fill_cells(leaves, bricks, around[i], known, wanted, bricks[i]);
      more = more || found[i] != 0;
    }
    for (std::size_t i = 0; i < bricks.size(); ++i) known[i] |= found[i];
  }
  for (std::size_t i = 0; i < bricks.size(); ++i) {
    for (Cells cells = bricks[i].after & ~known[i]; cells != 0; cells &= cells - 1)
      leaves[leaf_at(bricks[i], static_cast<unsigned>(std::countr_zero(cells)))] = brick_values[i];
  }
}

/// Gives the new nodes of a tree values. `values` are those of the old nodes, in order.
template <class Value>
void fill_values(std::vector<Value>& values, const Svo& svo, const FilledNodes& filled,
                 std::span<const Brick> bricks, const std::vector<Around>& around) {
  if (values.empty()) return;
  std::vector<Value> after(filled.size());
  auto carried = values.begin();
  for (std::size_t node = 0; node < after.size(); ++node) {
    if (!filled[node]) after[node] = *carried++;
  }
  const std::uint32_t parents = svo.level_begin[static_cast<std::size_t>(svo.depth) - 1];
  const std::span<Value> all(after);
  fill_leaves(all.subspan(svo.internal_count()),
              std::span<const Value>(all.subspan(parents - bricks.size(), bricks.size())), bricks,
              around);
  for (std::uint32_t node = parents; node < svo.internal_count(); ++node) {
    if (!filled[node]) continue;
    const int count = std::popcount(svo.masks[node]);
    glm::ivec3 sum(0);
    for (int c = 0; c < count; ++c)
      sum += glm::ivec3(after[svo.first_child[node] + static_cast<std::uint32_t>(c)]);
    after[node] = mean_of(sum, count, Value{});
  }
  values = std::move(after);
}

}  // namespace

int gap_to_fill(const Svo& svo, std::uint32_t points) {
  if (svo.depth < 2) return 0;
  const double leaves = svo.leaf_count(), growth = leaves / svo.node_count(svo.depth - 1);
  const bool random = points > kLeastRandomPoints * leaves && points < kMostRandomPoints * leaves;
  if (!(growth >= kLeastGrowth && growth < (random ? kRandomGrowth : kClosedGrowth))) return 0;
  return points > kCoarsePointsPerLeaf * leaves ? kWidestOfCoarse : kWidest;
}

FilledNodes fill_gaps(Svo& svo, NodeAttributes& attributes, int widest) {
  if (svo.depth < 2 || svo.leaf_count() == 0) return {};
  const std::vector<Around> around = nodes_around(svo, svo.depth - 2);
  const std::vector<Brick> bricks = find_bricks(svo, around, widest);
  if (std::all_of(bricks.begin(), bricks.end(),
                  [](const Brick& brick) { return brick.before == brick.after; }))
    return {};
  auto [after, filled] = tree_of(svo, bricks);
  svo = std::move(after);
  fill_values(attributes.colors, svo, filled, bricks, around);
  fill_values(attributes.normals, svo, filled, bricks, around);
  return std::move(filled);
}

}  // namespace pointreel
