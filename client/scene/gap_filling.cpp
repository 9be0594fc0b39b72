#include "client/scene/gap_filling.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <span>
#include <utility>

#include "client/scene/brick_cells.h"
#include "codec/core/build.h"
#include "codec/core/morton.h"

namespace pointreel {
namespace {

/// How many leaves a parent has on a surface whose gaps are worth filling. A closed surface has
/// four; random points, two to a cell, have 3.5. Below the least, gaps are many cells wide.
constexpr double kGapClosedGrowth = 3.4, kLeastGrowth = 1.7;
/// With so few points in a leaf, and more than the one that voxelised input has, random points
/// leave some cells empty even where the tree grows like this.
constexpr double kRandomGrowth = 3.9, kLeastRandomPoints = 1.5, kMostRandomPoints = 8.0;
/// If the leaves are coarser than the delta rule wants them, for a view from afar, the gaps are as
/// wide as before but have fewer cells.
constexpr double kCoarsePointsPerLeaf = 5.0;
constexpr int kWidestOfCoarse = 1;

/// From this growth on, scanned curves close when their gaps are filled. For that, a tree may have
/// this share of the leaves that delta asks for.
constexpr double kClosingGrowth = 2.35, kLeastOfDelta = 0.77;

/// The numbers of a node and of the nodes around it on its level (number_around). Where there is no
/// node, a number beyond the last.
using Around = std::array<std::uint32_t, 27>;

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
  std::array<Cells, 27> beside;
  beside[kMiddle] = there[kMiddle];
  for (std::size_t l = 0; l < kLines; ++l) {
    const Line& line = kMoves[l];
    // Cells within a distance backwards: the nearer the leaf ahead, the farther the leaf behind may
    // be.
    std::array<Cells, kWidest> behind{};
    for (std::size_t i = 0; i < static_cast<std::size_t>(widest); ++i)
      behind[i] = see(line.moves[1][i]) | (i > 0 ? behind[i - 1] : 0);
    for (std::size_t i = 0; i < static_cast<std::size_t>(widest); ++i) {
      const Cells ahead = see(line.moves[0][i]);
      between |= ahead & behind[static_cast<std::size_t>(widest) - 1 - i];
      if (i == 0) beside[kMiddle + 1 + l] = ahead;
    }
    beside[kMiddle - 1 - l] = behind[0];
  }
  for (const UnevenPair& pair : kUneven) {
    Cells others = 0;
    for (unsigned i = 0; i < pair.other_count; ++i) others |= beside[pair.others[i]];
    between |= beside[pair.ends[0]] & beside[pair.ends[1]] & ~others;
  }
  return between & ~there[kMiddle];
}

/// A node two levels above the leaves.
struct Brick {
  std::uint64_t key = 0;         ///< its Morton key among the nodes of its level
  Cells before = 0, after = 0;   ///< without and with the cells that fill gaps
  Cells ordered = 0;             ///< `after` in the order of the leaves
  std::uint32_t first_leaf = 0;  ///< its index among the leaves of the new tree
};

/// The Morton keys of the nodes of a level.
std::vector<std::uint64_t> keys_of(const Svo& svo, int level) {
  std::vector<std::uint64_t> keys(1), below;
  for (int l = 0; l < level; ++l) {
    below.clear();
    const std::uint32_t first = svo.level_begin[static_cast<std::size_t>(l)];
    for (std::size_t i = 0; i < keys.size(); ++i) {
      for (unsigned mask = svo.masks[first + i]; mask != 0; mask &= mask - 1)
        below.push_back(keys[i] << 3 | static_cast<unsigned>(std::countr_zero(mask)));
    }
    std::swap(keys, below);
  }
  return keys;
}

/// A place beside a brick, across one of its faces, and the bricks around both.
struct Across {
  std::array<int, 3> step{};
  std::size_t place = 0;  ///< its number around the brick
  struct Seen {
    std::uint8_t from_place, from_brick;
  };
  std::array<Seen, 18> around{};  ///< the eight beside the place that do not touch the face first
};
constexpr auto kAcross = [] {
  std::array<Across, 6> all{};
  for (std::size_t face = 0; face < all.size(); ++face) {
    const std::size_t axis = face / 2;
    Across& across = all[face];
    across.step[axis] = face % 2 == 0 ? 1 : -1;
    across.place = number_around(across.step);
    std::size_t count = 0;
    for (const bool first : {true, false}) {
      for (std::size_t n = 0; n < 27; ++n) {
        std::array<int, 3> at = place_around(n);
        if ((at[axis] == 0 && n != kMiddle) != first) continue;
        at[axis] += across.step[axis];
        if (at[axis] < -1 || at[axis] > 1) continue;
        across.around[count++] = {static_cast<std::uint8_t>(n),
                                  static_cast<std::uint8_t>(number_around(at))};
      }
    }
  }
  return all;
}();
constexpr std::size_t kBeside = 8;

/// The bricks that do not exist but have cells between two leaves, by their keys. No gap is wide
/// enough to cross a brick along any axis. So of the two leaves, one lies across a face, and the
/// other in one of the eight bricks that touch the new one elsewhere but not that face.
std::vector<Brick> new_bricks(const std::vector<Around>& around, std::span<const Cells> cells,
                              std::span<const std::uint64_t> keys, int widest) {
  const std::size_t none = around.size();
  std::vector<Brick> found;
  for (std::size_t i = 0; i < around.size(); ++i) {
    for (const Across& across : kAcross) {
      if (around[i][across.place] != none) continue;
      if (std::none_of(across.around.begin(), across.around.begin() + kBeside,
                       [&](const auto& seen) { return around[i][seen.from_brick] != none; }))
        continue;
      std::array<Cells, 27> there{};
      for (const Across::Seen& seen : across.around)
        there[seen.from_place] = cells[around[i][seen.from_brick]];
      const Cells between = cells_between(there, widest);
      if (between == 0) continue;
      const glm::ivec3 place = glm::ivec3(morton_decode(keys[i])) +
                               glm::ivec3(across.step[0], across.step[1], across.step[2]);
      found.push_back({morton_encode(glm::uvec3(place)), 0, between});
    }
  }
  std::sort(found.begin(), found.end(),
            [](const Brick& a, const Brick& b) { return a.key < b.key; });
  std::size_t count = 0;
  for (const Brick& brick : found) {
    if (count > 0 && found[count - 1].key == brick.key) {
      found[count - 1].after |= brick.after;
    } else {
      found[count++] = brick;
    }
  }
  found.resize(count);
  return found;
}

std::vector<Brick> find_bricks(const Svo& svo, const std::vector<Around>& around, int widest) {
  const int level = svo.depth - 2;
  const std::uint32_t first = svo.level_begin[static_cast<std::size_t>(level)];
  std::vector<Cells> cells(around.size() + 1, 0);  // the last stands for a missing brick
  for (std::size_t i = 0; i < around.size(); ++i) {
    std::uint32_t child = svo.first_child[first + i];
    for (unsigned mask = svo.masks[first + i]; mask != 0; mask &= mask - 1, ++child) {
      const auto octant = static_cast<unsigned>(std::countr_zero(mask));
      cells[i] |= kSpread[svo.masks[child]] << child_shift(octant);
    }
  }
  const std::vector<std::uint64_t> keys = keys_of(svo, level);
  const std::vector<Brick> added = new_bricks(around, cells, keys, widest);
  std::vector<Brick> bricks;
  bricks.reserve(around.size() + added.size());
  auto next = added.begin();
  for (std::size_t i = 0; i < around.size(); ++i) {
    for (; next != added.end() && next->key < keys[i]; ++next) bricks.push_back(*next);
    std::array<Cells, 27> there;
    for (std::size_t n = 0; n < 27; ++n) there[n] = cells[around[i][n]];
    bricks.push_back({keys[i], cells[i], cells[i] | cells_between(there, widest)});
  }
  bricks.insert(bricks.end(), next, added.end());
  std::uint32_t leaf = 0;
  for (Brick& brick : bricks) {
    brick.ordered = in_order(brick.after);
    brick.first_leaf = leaf;
    leaf += static_cast<std::uint32_t>(std::popcount(brick.after));
  }
  return bricks;
}

/// The tree with these leaves, and which of its nodes are new.
std::pair<Svo, FilledNodes> tree_of(const Svo& before, std::span<const Brick> bricks) {
  struct Level {
    std::vector<std::uint8_t> masks;
    FilledNodes filled;
  };
  // From the leaves up: those, their parents, the bricks, and what is above them.
  std::vector<Level> levels(static_cast<std::size_t>(before.depth) + 1);
  Level &leaves = levels[0], &parents = levels[1], &middle = levels[2];
  std::vector<std::uint64_t> keys;
  for (const Brick& brick : bricks) {
    unsigned children = 0;
    for (unsigned child = 0; child < 8; ++child) {
      const Cells cells = kChild << child_shift(child);
      if ((brick.after & cells) == 0) continue;
      children |= 1u << child;
      parents.masks.push_back(
          static_cast<std::uint8_t>(mask_of(brick.after >> child_shift(child))));
      parents.filled.push_back((brick.before & cells) == 0);
    }
    middle.masks.push_back(static_cast<std::uint8_t>(children));
    middle.filled.push_back(brick.before == 0);
    keys.push_back(brick.key);
    const Cells before_it = in_order(brick.before);
    for (Cells left = brick.ordered; left != 0; left &= left - 1)
      leaves.filled.push_back((before_it >> std::countr_zero(left) & 1u) == 0);
  }
  for (std::size_t l = 3; l < levels.size(); ++l) {
    std::size_t count = 0;
    for (std::size_t i = 0; i < keys.size(); ++i) {
      const std::uint64_t parent = keys[i] >> 3;
      const unsigned octant = static_cast<unsigned>(keys[i]) & 7u;
      if (count == 0 || keys[count - 1] != parent) {
        keys[count++] = parent;
        levels[l].masks.push_back(0);
        levels[l].filled.push_back(true);
      }
      levels[l].masks.back() |= static_cast<std::uint8_t>(1u << octant);
      if (!levels[l - 1].filled[i]) levels[l].filled.back() = false;
    }
    keys.resize(count);
  }
  Svo svo;
  svo.cube = before.cube;
  svo.depth = before.depth;
  FilledNodes filled;
  for (auto level = levels.rbegin(); level != levels.rend(); ++level) {
    svo.masks.insert(svo.masks.end(), level->masks.begin(), level->masks.end());
    filled.insert(filled.end(), level->filled.begin(), level->filled.end());
  }
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

/// Gives new leaves values, outwards from the old ones. Between any new leaf and the old ones that
/// it lies between, there are only leaves, so each is reached.
template <class Value>
void fill_leaves(std::span<Value> leaves, std::span<const Brick> bricks,
                 const std::vector<Around>& around) {
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
  fill_leaves(std::span<Value>(after).subspan(svo.internal_count()), bricks, around);
  for (std::uint32_t node = svo.internal_count(); node-- > 0;) {
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

int depth_that_closes(std::span<const std::uint32_t> occupied, std::uint64_t points, int depth,
                      double delta) {
  if (depth < 1) return depth;
  const double leaves = occupied[static_cast<std::size_t>(depth)],
               parents = occupied[static_cast<std::size_t>(depth) - 1];
  const double growth = leaves / parents;
  const bool gaps_stay = growth >= kLeastGrowth && growth < kClosingGrowth;
  const double wanted = (1.0 - delta) * static_cast<double>(points);
  return gaps_stay && parents >= kLeastOfDelta * wanted ? depth - 1 : depth;
}

int gap_to_fill(const Svo& svo, std::uint32_t points) {
  if (svo.depth < 2) return 0;
  const double leaves = svo.leaf_count(), growth = leaves / svo.node_count(svo.depth - 1);
  const bool random = points > kLeastRandomPoints * leaves && points < kMostRandomPoints * leaves;
  if (!(growth >= kLeastGrowth && growth < (random ? kRandomGrowth : kGapClosedGrowth))) return 0;
  return points > kCoarsePointsPerLeaf * leaves ? kWidestOfCoarse : kWidest;
}

FilledNodes fill_gaps(Svo& svo, NodeAttributes& attributes, int widest) {
  if (svo.depth < 2 || svo.leaf_count() == 0) return {};
  std::vector<Around> around = nodes_around(svo, svo.depth - 2);
  const std::vector<Brick> bricks = find_bricks(svo, around, widest);
  if (std::all_of(bricks.begin(), bricks.end(),
                  [](const Brick& brick) { return brick.before == brick.after; }))
    return {};
  auto [after, filled] = tree_of(svo, bricks);
  svo = std::move(after);
  if (bricks.size() > around.size()) around = nodes_around(svo, svo.depth - 2);
  fill_values(attributes.colors, svo, filled, bricks, around);
  fill_values(attributes.normals, svo, filled, bricks, around);
  return std::move(filled);
}

}  // namespace pointreel
