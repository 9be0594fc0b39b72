#include "common/octree/svo.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <string>

namespace pointreel {
namespace {

/// Scanned frames are rarely divided deeper than this: what sort_to_depth tries before all levels.
/// Three digits of the radix sort.
constexpr int kCommonLevels = 11;

std::uint32_t quantise(double distance, double cells_per_unit) {
  constexpr double kLast = (1 << kMaxDepth) - 1;
  // Clamped while it is a double: a point far outside would overflow the integer.
  const double cell = distance * cells_per_unit;
  const double at_least_0 = cell < 0.0 ? 0.0 : cell;
  return static_cast<std::uint32_t>(at_least_0 > kLast ? kLast : at_least_0);
}

bool meets(const DepthRule& rule, std::uint32_t cells, std::uint64_t n) {
  return static_cast<double>(cells) >= (1.0 - rule.delta) * static_cast<double>(n);
}

/// Masks of the parents of `keys` (the distinct keys of one level, sorted, not none), appended to
/// `masks`; `keys` becomes the parents' keys. Without a branch on the data, which would be guessed
/// wrong at every other node.
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

/// oct(h) for every h up to sorted.levels. A new cell is occupied at level h wherever two
/// neighbours differ at level h or above, so one histogram of the highest differing bit gives them
/// all.
void count_occupied(SortedPoints& sorted) {
  std::array<std::uint32_t, 64> differing_width{};
  for (std::size_t i = 1; i < sorted.points.size(); ++i) {
    ++differing_width[static_cast<std::size_t>(
        std::bit_width(sorted.points[i - 1].key ^ sorted.points[i].key))];
  }
  std::uint32_t cells = sorted.points.empty() ? 0 : 1;
  for (int level = 0; level <= sorted.levels; ++level) {
    // Keys that part at this level differ in one of the three bits that it adds.
    const int width = 3 * (sorted.levels - level);
    for (int bit = width + 1; bit <= width + 3 && level > 0; ++bit) {
      cells += differing_width[static_cast<std::size_t>(bit)];
    }
    sorted.occupied.push_back(cells);
  }
}

}  // namespace

double Svo::cell_size(int level) const { return std::ldexp(cube.edge, -level); }

SortedPoints sort_points(const PointCloud& cloud, const Cube& cube, int levels) {
  SortedPoints sorted;
  sorted.cube = cube;
  sorted.levels = levels;
  const glm::dvec3 offset = cloud.origin - cube.origin;
  const double cells_per_unit = std::ldexp(1.0, kMaxDepth) / cube.edge;
  const int drop = kMaxDepth - levels;
  const auto key_of = [&](const glm::vec3& position) {
    const glm::dvec3 p = glm::dvec3(position) + offset;
    return morton_encode({quantise(p.x, cells_per_unit) >> drop,
                          quantise(p.y, cells_per_unit) >> drop,
                          quantise(p.z, cells_per_unit) >> drop});
  };
  if (3 * levels + kPackedIndexBits <= 64) {
    std::vector<std::uint64_t> packed(cloud.size());
    for (std::size_t i = 0; i < packed.size(); ++i) {
      packed[i] = key_of(cloud.positions[i]) << kPackedIndexBits | i;
    }
    radix_sort(packed, 3 * levels);
    sorted.points.reserve(cloud.size());
    constexpr std::uint64_t kIndex = (std::uint64_t{1} << kPackedIndexBits) - 1;
    for (const std::uint64_t point : packed) {
      sorted.points.push_back(
          {point >> kPackedIndexBits, static_cast<std::uint32_t>(point & kIndex)});
    }
  } else {
    sorted.points.resize(cloud.size());
    for (std::uint32_t i = 0; i < sorted.points.size(); ++i) {
      sorted.points[i] = {key_of(cloud.positions[i]), i};
    }
    radix_sort(sorted.points, 3 * levels);
  }
  count_occupied(sorted);
  return sorted;
}

Result<int> choose_depth(std::span<const std::uint32_t> occupied, std::uint64_t n,
                         const DepthRule& rule) {
  if (rule.most < 0 || rule.most > kMaxDepth) {
    return fail("depth " + std::to_string(rule.most) + " is not between 0 and " +
                std::to_string(kMaxDepth));
  }
  if (rule.kind == DepthRule::Kind::fixed) {
    if (rule.depth < 0 || rule.depth > kMaxDepth) {
      return fail("depth " + std::to_string(rule.depth) + " is not between 0 and " +
                  std::to_string(kMaxDepth));
    }
    return std::min(rule.depth, rule.most);
  }
  if (!(rule.delta >= 0.0)) return fail("delta must be a number of at least 0");
  // ERRATA 4: the criterion alone never ends where points coincide, so it also stops at the level
  // that tells all distinct points apart. A level like the one above it is no reason to stop.
  std::size_t depth = 0;
  const auto most = static_cast<std::size_t>(rule.most);
  while (depth < most && depth + 1 < occupied.size() && occupied[depth] < occupied.back() &&
         !meets(rule, occupied[depth], n)) {
    ++depth;
  }
  return static_cast<int>(depth);
}

Result<SortedToDepth> sort_to_depth(const PointCloud& cloud, const Cube& cube,
                                    const DepthRule& rule) {
  if (rule.kind == DepthRule::Kind::fixed) {
    const auto depth = choose_depth({}, 0, rule);
    if (!depth) return tl::unexpected(depth.error());
    return SortedToDepth{sort_points(cloud, cube, *depth), *depth};
  }
  for (int levels = kCommonLevels;; levels = kMaxDepth) {
    SortedPoints sorted = sort_points(cloud, cube, levels);
    const auto depth = choose_depth(sorted.occupied, cloud.size(), rule);
    if (!depth) return tl::unexpected(depth.error());
    // A depth that does not meet the rule was only the last at which these levels tell points
    // apart.
    const std::uint32_t cells = sorted.occupied[static_cast<std::size_t>(*depth)];
    if (levels == kMaxDepth || *depth == rule.most || meets(rule, cells, cloud.size())) {
      return SortedToDepth{std::move(sorted), *depth};
    }
  }
}

Svo build_svo(const SortedPoints& sorted, int depth) {
  Svo svo;
  svo.cube = sorted.cube;
  svo.depth = depth;
  std::vector<std::uint64_t> keys(sorted.points.size());
  const int shift = 3 * (sorted.levels - depth);
  std::size_t distinct = 0;
  std::uint64_t previous = ~std::uint64_t{0};
  for (const KeyIndex& point : sorted.points) {
    const std::uint64_t key = point.key >> shift;
    distinct += static_cast<std::size_t>(key != previous);
    keys[distinct - 1] = previous = key;
  }
  keys.resize(distinct);
  if (!keys.empty()) {
    // From the leaves up, each level behind the one below it; then turned round level by level.
    std::vector<std::uint8_t> upward;
    std::vector<std::size_t> begin;
    for (int level = depth; level > 0; --level) {
      begin.push_back(upward.size());
      reduce_level(keys, upward);
    }
    svo.masks.reserve(upward.size());
    std::size_t end = upward.size();
    for (auto level = begin.rbegin(); level != begin.rend(); ++level) {
      const auto from = upward.begin() + static_cast<std::ptrdiff_t>(*level);
      svo.masks.insert(svo.masks.end(), from, upward.begin() + static_cast<std::ptrdiff_t>(end));
      end = *level;
    }
  }
  index_svo(svo, !keys.empty());
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
  // Up to 2^28 masks of at most 8 children each, node numbers fit 32 bits.
  if (!occupied || svo.masks.size() > (std::size_t{1} << 28)) return false;
  std::uint32_t next = 1;  // the root is node 0; children follow in order
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
  if (svo.node_count() == 0) return {};
  std::vector<glm::uvec3> cells{glm::uvec3(0)}, children;
  for (int level = 0; level < svo.depth; ++level) {
    children.resize(svo.node_count(level + 1));
    const std::uint8_t* mask = svo.masks.data() + svo.level_begin[static_cast<std::size_t>(level)];
    glm::uvec3* child = children.data();
    for (const glm::uvec3& cell : cells) {
      for (unsigned bits = *mask++; bits != 0; bits &= bits - 1) {
        const unsigned octant = static_cast<unsigned>(std::countr_zero(bits));
        *child++ = {cell.x * 2 + (octant & 1u), cell.y * 2 + (octant >> 1 & 1u),
                    cell.z * 2 + (octant >> 2)};
      }
    }
    cells.swap(children);
  }
  return cells;
}

}  // namespace pointreel
