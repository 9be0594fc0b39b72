#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <compare>
#include <cstddef>
#include <cstring>
#include <memory>
#include <numeric>
#include <optional>
#include <span>

#include "codec/core/build.h"
#include "codec/core/morton.h"
#include "common/base/blocks.h"
#include "common/base/concat.h"
#include "common/base/try.h"
#include "pointreel/octree.h"

namespace pointreel {
namespace {

/// sort_to_depth tries this many levels first, since scanned frames are rarely divided deeper. They
/// take three digits of the radix sort.
constexpr int kCommonLevels = 11;

/// Calls visit(i, key) for each point, a block of points in order. Works on some coordinates at a
/// time, x, y and z alike, so that the compiler can turn them into cells with vector instructions.
template <class Visit>
void for_each_key(const PointCloud& cloud, const Cube& cube, int levels, const Blocks& blocks,
                  const Executor& executor, const Visit& visit) {
  constexpr std::size_t kAtOnce = 64;
  constexpr double kLast = (1 << kMaxDepth) - 1;
  const glm::dvec3 corner = cloud.origin - cube.origin;
  const double cells_per_unit = std::ldexp(1.0, kMaxDepth) / cube.edge;
  const int drop = kMaxDepth - levels;
  std::array<double, 3 * kAtOnce> offset;
  for (std::size_t i = 0; i < offset.size(); ++i) offset[i] = corner[static_cast<int>(i % 3)];
  for_each_block(executor, blocks, [&](std::size_t, std::size_t begin, std::size_t end) {
    std::array<std::int32_t, 3 * kAtOnce> cells;
    for (; begin < end; begin += kAtOnce) {
      const std::size_t count = std::min(kAtOnce, end - begin);
      const float* const coordinates = &cloud.positions[begin].x;
      for (std::size_t i = 0; i < 3 * count; ++i) {
        // Clamped before the conversion, since a point far outside would overflow the integer.
        const double cell = (static_cast<double>(coordinates[i]) + offset[i]) * cells_per_unit;
        const double at_least_0 = cell > 0.0 ? cell : 0.0;
        cells[i] = static_cast<std::int32_t>(at_least_0 < kLast ? at_least_0 : kLast) >> drop;
      }
      for (std::size_t i = 0; i < count; ++i) {
        visit(begin + i,
              morton_encode(glm::uvec3(cells[3 * i], cells[3 * i + 1], cells[3 * i + 2])));
      }
    }
  });
}

bool meets(const DepthRule& rule, std::uint32_t cells, std::uint64_t n) {
  return static_cast<double>(cells) >= (1.0 - rule.delta) * static_cast<double>(n);
}

/// The number of points of a run, which lie in the same cell, that are farther apart than
/// `tolerance`. A point is compared with a few others only, which bounds the time, so that the
/// result may be too large where many points lie in a plane across the x-axis.
std::size_t count_distinct(std::span<glm::vec3> run, float tolerance) {
  constexpr std::size_t kCompared = 8;
  std::sort(run.begin(), run.end(), [](const glm::vec3& a, const glm::vec3& b) {
    for (int axis = 0; axis < 3; ++axis) {
      const auto order = std::strong_order(a[axis], b[axis]);  // has a place for NaN, too
      if (order != 0) return order < 0;
    }
    return false;
  });
  std::size_t distinct = 0;  // those found so far are moved to the front
  for (const glm::vec3& point : run) {
    bool repeats = false;
    for (std::size_t i = distinct; i > 0 && i + kCompared > distinct && !repeats; --i) {
      const glm::vec3 apart = glm::abs(point - run[i - 1]);
      repeats = std::max({apart.x, apart.y, apart.z}) <= tolerance;
    }
    if (!repeats) run[distinct++] = point;
  }
  return distinct;
}

/// The number of points that are farther apart than half a cell of the deepest level. Those that
/// share no cell of the sorted levels need no look.
std::uint64_t count_distinct(const PointCloud& cloud, const SortedPoints& sorted,
                             const Executor& executor) {
  const auto tolerance = static_cast<float>(std::ldexp(sorted.cube.edge, -kMaxDepth - 1));
  const std::vector<KeyIndex>& points = sorted.points;
  const Blocks blocks(executor, points.size(), kLeastPerBlock);
  std::vector<std::uint64_t> distinct(blocks.count());
  for_each_block(executor, blocks, [&](std::size_t block, std::size_t begin, std::size_t end) {
    // Runs count where they begin.
    while (begin > 0 && begin < end && points[begin].key == points[begin - 1].key) ++begin;
    std::vector<glm::vec3> run;
    for (std::size_t next = begin; begin < end; begin = next) {
      ++next;
      while (next < points.size() && points[next].key == points[begin].key) ++next;
      if (next - begin == 1) {
        ++distinct[block];
        continue;
      }
      run.clear();
      for (std::size_t i = begin; i < next; ++i) run.push_back(cloud.positions[points[i].index]);
      distinct[block] += count_distinct(run, tolerance);
    }
  });
  return std::accumulate(distinct.begin(), distinct.end(), std::uint64_t{0});
}

/// Appends the masks of the parents of `keys` to `masks`, and replaces `keys` by the keys of the
/// parents. `keys` are the distinct keys of one level, sorted, at least one. There is no branch on
/// the data, since the processor would mispredict it at every other node.
void reduce_level(std::vector<std::uint64_t>& keys, std::vector<std::uint8_t>& masks) {
  const std::size_t begin = masks.size();
  masks.resize(begin + keys.size());
  std::uint8_t* mask = masks.data() + begin;
  std::uint64_t* const parents = keys.data();
  std::size_t last = 0;
  std::uint64_t parent = keys.front() >> 3;
  for (const std::uint64_t key : keys) {
    last += static_cast<std::size_t>(key >> 3 != parent);
    parent = key >> 3;
    parents[last] = parent;
    mask[last] = static_cast<std::uint8_t>(mask[last] | 1u << (key & 7u));
  }
  keys.resize(last + 1);
  masks.resize(begin + last + 1);
}

/// The nodes above a block of sorted points. Its first node of a level may be the last one of the
/// block before, too: these have parts of one node's children each.
struct BlockTree {
  std::vector<std::uint8_t> masks;    ///< those of the level above the leaves first
  std::vector<std::uint32_t> counts;  ///< of the nodes of each level
  std::vector<std::uint32_t> begin;   ///< the number of its first node in the tree's level
  std::uint64_t first = 0, last = 0;  ///< the keys of its leaves
  std::size_t shared = 0;             ///< on so many levels, the first node is the block's before

  BlockTree() = default;
  /// `points`: at least one. `shift` makes leaves of their keys.
  BlockTree(std::span<const KeyIndex> points, int shift, int depth)
      : counts(static_cast<std::size_t>(depth) + 1), begin(counts.size()) {
    std::vector<std::uint64_t> keys(points.size());
    std::size_t distinct = 0;
    std::uint64_t previous = ~std::uint64_t{0};
    for (const KeyIndex& point : points) {
      const std::uint64_t key = point.key >> shift;
      distinct += static_cast<std::size_t>(key != previous);
      keys[distinct - 1] = previous = key;
    }
    keys.resize(distinct);
    first = keys.front();
    last = keys.back();
    for (std::size_t level = counts.size();;) {
      counts[--level] = static_cast<std::uint32_t>(keys.size());
      if (level == 0) break;
      reduce_level(keys, masks);
    }
  }

  void share_with(const BlockTree& before, int depth) {
    const auto width = static_cast<int>(std::bit_width(before.last ^ first));
    shared = static_cast<std::size_t>(depth + 1 - (width + 2) / 3);
  }

  /// Sets the nodes that are not shared.
  void copy_to(Svo& svo) const {
    const std::uint8_t* mask = masks.data() + masks.size();
    for (std::size_t level = 0; level + 1 < counts.size(); ++level) {
      mask -= counts[level];
      const std::uint32_t node = svo.level_begin[level] + begin[level];
      std::uint32_t child = svo.level_begin[level + 1] + begin[level + 1];
      const std::uint32_t count = counts[level];
      std::uint32_t i = 0;
      if (level < shared) child += static_cast<std::uint32_t>(std::popcount(mask[i++]));
      std::copy(mask + i, mask + count, svo.masks.data() + node + i);
      for (; i < count; ++i) {
        svo.first_child[node + i] = child;
        child += static_cast<std::uint32_t>(std::popcount(mask[i]));
      }
    }
  }

  /// Adds the children of nodes that an earlier block has set.
  void add_shared_to(Svo& svo) const {
    const std::uint8_t* mask = masks.data() + masks.size();
    for (std::size_t level = 0; level < std::min(shared, counts.size() - 1); ++level) {
      mask -= counts[level];
      std::uint8_t& whole = svo.masks[svo.level_begin[level] + begin[level]];
      whole = static_cast<std::uint8_t>(whole | *mask);
    }
  }
};

/// Counts the occupied cells of every level at once. In sorted order, a key begins a new cell of
/// level h if it differs from the key before at level h or above, so a histogram of the widths of
/// these differences gives the counts of all levels.
class OccupiedCounter {
 public:
  /// Before the first key of all.
  OccupiedCounter() = default;
  /// After the key of another counter's last point.
  explicit OccupiedCounter(std::uint64_t previous) : previous_(previous) {}

  /// To be called for the keys of consecutive points, in order.
  void add(std::uint64_t key) {
    ++widths_[static_cast<std::size_t>(std::bit_width(previous_ ^ key))];
    previous_ = key;
  }

  void add(const OccupiedCounter& other) {
    for (std::size_t i = 0; i < widths_.size(); ++i) widths_[i] += other.widths_[i];
  }

  std::vector<std::uint32_t> counts(int levels) const {
    std::vector<std::uint32_t> occupied;
    std::uint32_t cells = widths_[kFirst];
    for (int level = 0; level <= levels; ++level) {
      // Keys that separate at this level first differ in one of the three bits that it adds.
      const int width = 3 * (levels - level);
      for (int bit = width + 1; bit <= width + 3 && level > 0; ++bit) {
        cells += widths_[static_cast<std::size_t>(bit)];
      }
      occupied.push_back(cells);
    }
    return occupied;
  }

 private:
  /// The width counted for the first key, which differs from `previous_` in the highest bit.
  static constexpr std::size_t kFirst = 64;
  std::array<std::uint32_t, kFirst + 1> widths_{};
  std::uint64_t previous_ = ~std::uint64_t{0};
};

/// The coordinates of a cell in one number: x, y from bit 21 on, and z from bit 42 on.
typedef std::uint64_t Cells __attribute__((vector_size(16)));
constexpr int kAxisBits = 21;

std::uint32_t coordinate(std::uint64_t cell, int axis) {
  return static_cast<std::uint32_t>(cell >> axis * kAxisBits) & ((1u << kAxisBits) - 1);
}

/// For each half of a mask, the children there, one after the other, as cells of their parent.
constexpr auto kHalves = [] {
  std::array<std::array<std::uint64_t, 4>, 16> all{};
  for (unsigned mask = 0; mask < 16; ++mask) {
    std::size_t count = 0;
    for (std::uint64_t child = 0; child < 4; ++child) {
      if ((mask >> child & 1) != 0) all[mask][count++] = (child & 1) | (child >> 1) << kAxisBits;
    }
  }
  return all;
}();

/// The cells of a level, in order. The tree is not empty.
std::vector<std::uint64_t> cells_of(const Svo& svo, int level) {
  std::vector<std::uint64_t> cells{0}, children;
  for (int above = 0; above < level; ++above) {
    // No branch depends on a mask: four children are written for each half, and those too many are
    // written over.
    children.resize(svo.node_count(above + 1) + 4);
    const std::uint8_t* mask = svo.masks.data() + svo.level_begin[static_cast<std::size_t>(above)];
    const std::uint8_t* const end = mask + svo.node_count(above);
    const std::uint64_t* cell = cells.data();
    std::uint64_t* child = children.data();
    const auto add = [&child](std::uint64_t parent, unsigned half) {
      Cells four[2];
      std::memcpy(four, kHalves[half].data(), sizeof(four));
      for (Cells& two : four) two += parent;
      std::memcpy(child, four, sizeof(four));
      child += std::popcount(half);
    };
    for (; mask < end; ++mask, ++cell) {
      add(2 * *cell, *mask & 15u);
      add(2 * *cell + (std::uint64_t{1} << 2 * kAxisBits), *mask >> 4u);
    }
    cells.swap(children);
  }
  cells.resize(svo.node_count(level));
  return cells;
}

typedef float Float4 __attribute__((vector_size(16)));
typedef std::int32_t Int4 __attribute__((vector_size(16)));

/// For each mask, its children; for each child, which of its coordinates are the larger ones.
constexpr auto kChildren = [] {
  std::array<std::array<std::uint8_t, 8>, 256> all{};
  for (unsigned mask = 0; mask < 256; ++mask) {
    std::size_t count = 0;
    for (unsigned child = 0; child < 8; ++child) {
      if ((mask >> child & 1) != 0) all[mask][count++] = static_cast<std::uint8_t>(child);
    }
  }
  return all;
}();
constexpr std::array<Int4, 8> kLarger = {Int4{0, 0, 0, 0},   Int4{-1, 0, 0, 0},  Int4{0, -1, 0, 0},
                                         Int4{-1, -1, 0, 0}, Int4{0, 0, -1, 0},  Int4{-1, 0, -1, 0},
                                         Int4{0, -1, -1, 0}, Int4{-1, -1, -1, 0}};

Result<void> check_depth(int depth) {
  if (depth >= 0 && depth <= kMaxDepth) return {};
  return fail(ErrorCode::argument, concat("depth ", depth, " is not between 0 and ", kMaxDepth));
}

}  // namespace

double Svo::cell_size(int level) const { return std::ldexp(cube.edge, -level); }

SortedPoints sort_points(const PointCloud& cloud, const Cube& cube, int levels,
                         const Executor& executor) {
  SortedPoints sorted;
  sorted.cube = cube;
  sorted.levels = levels;
  sorted.points.resize(cloud.size());
  const Blocks blocks(executor, cloud.size(), kLeastPerBlock);
  std::vector<OccupiedCounter> occupied(blocks.count());
  // Calls keep(i) for each point, too.
  const auto count = [&](const auto& key_at, const auto& keep) {
    for_each_block(executor, blocks, [&](std::size_t block, std::size_t begin, std::size_t end) {
      OccupiedCounter counter;
      if (begin > 0) counter = OccupiedCounter(key_at(begin - 1));
      for (std::size_t i = begin; i < end; ++i) {
        counter.add(key_at(i));
        keep(i);
      }
      occupied[block] = counter;
    });
  };
  if (3 * levels + kPackedIndexBits <= 64) {
    // Not set here, since that would take a good part of the time.
    const auto packed = std::make_unique_for_overwrite<std::uint64_t[]>(2 * cloud.size());
    for_each_key(cloud, cube, levels, blocks, executor, [&](std::size_t i, std::uint64_t key) {
      packed[i] = key << kPackedIndexBits | i;
    });
    const std::span<std::uint64_t> both(packed.get(), 2 * cloud.size());
    const auto in_order =
        radix_sort(both.first(cloud.size()), both.last(cloud.size()), 3 * levels, executor);
    constexpr std::uint64_t kIndex = (std::uint64_t{1} << kPackedIndexBits) - 1;
    const auto key_at = [in_order](std::size_t i) { return in_order[i] >> kPackedIndexBits; };
    count(key_at, [&](std::size_t i) {
      sorted.points[i] = {key_at(i), static_cast<std::uint32_t>(in_order[i] & kIndex)};
    });
  } else {
    for_each_key(cloud, cube, levels, blocks, executor, [&](std::size_t i, std::uint64_t key) {
      sorted.points[i] = {key, static_cast<std::uint32_t>(i)};
    });
    radix_sort(sorted.points, 3 * levels, executor);
    count([&](std::size_t i) { return sorted.points[i].key; }, [](std::size_t) {});
  }
  for (std::size_t i = 1; i < occupied.size(); ++i) occupied.front().add(occupied[i]);
  sorted.occupied = occupied.front().counts(levels);
  return sorted;
}

Result<int> choose_depth(std::span<const std::uint32_t> occupied, std::uint64_t n,
                         const DepthRule& rule) {
  TRY(check_depth(rule.most));
  if (rule.kind == DepthRule::Kind::fixed) {
    TRY(check_depth(rule.depth));
    return std::min(rule.depth, rule.most);
  }
  if (!(rule.delta >= 0.0)) {
    return fail(ErrorCode::argument, "delta must be a number of at least 0");
  }
  TRY(check_depth(rule.least));
  // Where points coincide the criterion may never be met, so the search also ends at the level that
  // tells all distinct points apart. It must not end at a level merely because it has as many cells
  // as the one above.
  if (occupied.empty()) return 0;
  const auto most = std::min(static_cast<std::size_t>(rule.most), occupied.size() - 1);
  std::size_t depth = std::min(static_cast<std::size_t>(rule.least), most);
  while (depth < most && occupied[depth] < occupied.back() && !meets(rule, occupied[depth], n)) {
    ++depth;
  }
  return static_cast<int>(depth);
}

Result<SortedToDepth> sort_to_depth(const PointCloud& cloud, const Cube& cube,
                                    const DepthRule& rule, const Executor& executor) {
  if (rule.kind == DepthRule::Kind::fixed) {
    const int depth = TRY(choose_depth({}, 0, rule));
    return SortedToDepth{sort_points(cloud, cube, depth, executor), depth};
  }
  const int first = std::clamp(rule.least, kCommonLevels, kMaxDepth);
  std::optional<std::uint64_t> distinct;
  for (int levels = first;; levels = kMaxDepth) {
    SortedPoints sorted = sort_points(cloud, cube, levels, executor);
    if (!distinct) distinct = count_distinct(cloud, sorted, executor);
    const int depth = TRY(choose_depth(sorted.occupied, *distinct, rule));
    // If this depth does not meet the rule, it is only where the levels sorted so far end.
    const std::uint32_t cells = sorted.occupied[static_cast<std::size_t>(depth)];
    if (levels == kMaxDepth || depth == rule.most || meets(rule, cells, *distinct)) {
      return SortedToDepth{std::move(sorted), depth};
    }
  }
}

DepthRule coding_rule(DepthRule rule, std::size_t points) {
  // One level less for each four times as many points: delta divides surfaces of some thousands of
  // points as far by itself.
  constexpr int kLeastForOne = 13;
  if (rule.delta >= 1.0) return rule;  // not even the distances between points count
  rule.least =
      std::max({0, rule.least, kLeastForOne - static_cast<int>(std::bit_width(points)) / 2});
  return rule;
}

Svo build_svo(const SortedPoints& sorted, int depth, const Executor& executor) {
  Svo svo;
  svo.cube = sorted.cube;
  svo.depth = depth;
  const auto levels = static_cast<std::size_t>(depth) + 1;
  svo.level_begin.assign(levels + 1, 0);
  if (sorted.points.empty()) return svo;
  const int shift = 3 * (sorted.levels - depth);
  const Blocks blocks(executor, sorted.points.size(), kLeastPerBlock);
  std::vector<BlockTree> trees(blocks.count());
  for_each_block(executor, blocks, [&](std::size_t block, std::size_t begin, std::size_t end) {
    trees[block] = BlockTree(std::span(sorted.points).subspan(begin, end - begin), shift, depth);
  });
  // Where the nodes of each block go: numbers among those of their level, as long as the levels'
  // own numbers are not known.
  std::vector<std::uint32_t> counts(levels);
  for (std::size_t block = 0; block < trees.size(); ++block) {
    BlockTree& tree = trees[block];
    if (block > 0) tree.share_with(trees[block - 1], depth);
    for (std::size_t level = 0; level < levels; ++level) {
      tree.begin[level] = counts[level] - (level < tree.shared ? 1 : 0);
      counts[level] = tree.begin[level] + tree.counts[level];
    }
  }
  std::partial_sum(counts.begin(), counts.end(), svo.level_begin.begin() + 1);
  svo.masks.resize(svo.level_begin[levels - 1]);
  svo.first_child.resize(svo.masks.size());
  for_each_block(executor, blocks,
                 [&](std::size_t block, std::size_t, std::size_t) { trees[block].copy_to(svo); });
  for (const BlockTree& tree : trees) tree.add_shared_to(svo);
  return svo;
}

bool index_svo(Svo& svo, bool occupied) {
  const std::size_t levels = static_cast<std::size_t>(svo.depth) + 1;
  svo.level_begin.assign(levels + 1, 0);
  svo.first_child.resize(svo.masks.size());
  if (svo.masks.empty()) {
    if (occupied && svo.depth == 0) svo.level_begin[1] = 1;
    return !occupied || svo.depth == 0;
  }
  // With up to 2^28 masks of at most 8 children each, the numbers of nodes fit into 32 bits.
  if (!occupied || svo.masks.size() > (std::size_t{1} << 28)) return false;
  std::uint32_t next = 1;  // the root is node 0, and the children follow in order
  for (std::size_t i = 0; i < svo.masks.size(); ++i) {
    if (svo.masks[i] == 0) return false;
    svo.first_child[i] = next;
    next += static_cast<std::uint32_t>(std::popcount(svo.masks[i]));
  }
  svo.level_begin[1] = 1;
  for (std::size_t level = 1; level < levels; ++level) {
    const std::size_t begin = svo.level_begin[level];
    if (begin > svo.masks.size()) return false;
    svo.level_begin[level + 1] = begin < svo.masks.size() ? svo.first_child[begin] : next;
  }
  return svo.level_begin[levels - 1] == svo.masks.size() && svo.level_begin[levels] == next;
}

Svo truncate(const Svo& svo, int depth) {
  if (depth >= svo.depth) return svo;
  Svo cut;
  cut.cube = svo.cube;
  cut.depth = depth;
  const auto level = static_cast<std::ptrdiff_t>(depth);
  cut.level_begin.assign(svo.level_begin.begin(), svo.level_begin.begin() + level + 2);
  const auto internal =
      static_cast<std::ptrdiff_t>(cut.level_begin[static_cast<std::size_t>(depth)]);
  cut.masks.assign(svo.masks.begin(), svo.masks.begin() + internal);
  cut.first_child.assign(svo.first_child.begin(), svo.first_child.begin() + internal);
  return cut;
}

std::vector<glm::uvec3> leaf_cells(const Svo& svo) {
  std::vector<glm::uvec3> leaves;
  if (svo.node_count() == 0) return leaves;
  leaves.reserve(svo.leaf_count());
  for (const std::uint64_t cell : cells_of(svo, svo.depth)) {
    leaves.push_back({coordinate(cell, 0), coordinate(cell, 1), coordinate(cell, 2)});
  }
  return leaves;
}

PointCloud leaf_centers(const Svo& svo) {
  PointCloud cloud;
  cloud.origin = svo.cube.origin;
  if (svo.node_count() == 0) return cloud;
  const double edge = svo.cell_size(svo.depth);
  const auto center = [edge](std::uint32_t c) { return static_cast<float>((c + 0.5) * edge); };
  if (svo.depth == 0) {
    cloud.positions.emplace_back(center(0));
    return cloud;
  }
  cloud.positions.resize(svo.leaf_count());
  const std::uint8_t* mask =
      svo.masks.data() + svo.level_begin[static_cast<std::size_t>(svo.depth) - 1];
  glm::vec3* leaf = cloud.positions.data();
  // Four or eight leaves of 16 bytes are written for each parent; those too many, and the last four
  // bytes of each, are written over. There is no room for that behind the last leaves.
  const glm::vec3* const end = leaf + cloud.positions.size();
  for (const std::uint64_t parent : cells_of(svo, svo.depth - 1)) {
    Float4 low{}, high{};
    for (int axis = 0; axis < 3; ++axis) {
      low[axis] = center(2 * coordinate(parent, axis));
      high[axis] = center(2 * coordinate(parent, axis) + 1);
    }
    const auto& children = kChildren[*mask];
    const auto at = [&](std::size_t i) -> Float4 { return kLarger[children[i]] ? high : low; };
    const auto put = [&](std::size_t i) {
      const Float4 position = at(i);
      std::memcpy(leaf + i, &position, sizeof(position));
    };
    const auto count = static_cast<std::size_t>(std::popcount(*mask++));
    if (end - leaf > 8) {
      for (std::size_t i = 0; i < 4; ++i) put(i);
      if (count > 4) {
        for (std::size_t i = 4; i < 8; ++i) put(i);
      }
    } else {
      for (std::size_t i = 0; i < count; ++i) {
        const Float4 position = at(i);
        leaf[i] = {position[0], position[1], position[2]};
      }
    }
    leaf += count;
  }
  return cloud;
}

}  // namespace pointreel
