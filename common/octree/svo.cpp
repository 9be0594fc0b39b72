#include "common/octree/svo.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <string>

namespace pointreel {
namespace {

/// Level at which two different keys first enter different cells: 1 to kMaxDepth.
int first_differing_level(std::uint64_t a, std::uint64_t b) {
  return kMaxDepth - (static_cast<int>(std::bit_width(a ^ b)) - 1) / 3;
}

std::uint32_t quantise(double distance, double cells_per_unit) {
  constexpr double kLast = (1 << kMaxDepth) - 1;
  // Clamped while it is a double: a point far outside would overflow the integer.
  return static_cast<std::uint32_t>(std::clamp(distance * cells_per_unit, 0.0, kLast));
}

/// Masks of the parents of `keys` (the distinct keys of one level, sorted), appended to `masks`;
/// `keys` becomes the parents' keys.
void reduce_level(std::vector<std::uint64_t>& keys, std::vector<std::uint8_t>& masks) {
  const std::size_t begin = masks.size();
  masks.resize(begin + keys.size());
  std::uint8_t* mask = masks.data() + begin;
  std::size_t parents = 0;
  std::uint64_t parent = ~std::uint64_t{0};
  std::uint8_t children = 0;
  for (const std::uint64_t key : keys) {
    if (key >> 3 != parent) {
      if (children != 0) mask[parents - 1] = children;
      parent = key >> 3;
      keys[parents++] = parent;
      children = 0;
    }
    children = static_cast<std::uint8_t>(children | 1u << (key & 7u));
  }
  mask[parents - 1] = children;
  keys.resize(parents);
  masks.resize(begin + parents);
}

}  // namespace

double Svo::cell_size(int level) const { return std::ldexp(cube.edge, -level); }

SortedPoints sort_points(const PointCloud& cloud, const Cube& cube) {
  SortedPoints sorted;
  sorted.cube = cube;
  sorted.points.resize(cloud.size());
  const glm::dvec3 offset = cloud.origin - cube.origin;
  const double cells_per_unit = std::ldexp(1.0, kMaxDepth) / cube.edge;
  for (std::uint32_t i = 0; i < sorted.points.size(); ++i) {
    const glm::dvec3 p = glm::dvec3(cloud.positions[i]) + offset;
    sorted.points[i] = {morton_encode({quantise(p.x, cells_per_unit), quantise(p.y, cells_per_unit),
                                       quantise(p.z, cells_per_unit)}),
                        i};
  }
  radix_sort(sorted.points);
  if (cloud.empty()) return sorted;

  // A new cell is occupied at level h wherever two neighbours differ at level h or above, so one
  // histogram of the first differing level gives oct(h) for every h at once.
  std::array<std::uint32_t, kMaxDepth + 1> first_differs{};
  for (std::size_t i = 1; i < sorted.points.size(); ++i) {
    const std::uint64_t a = sorted.points[i - 1].key, b = sorted.points[i].key;
    if (a != b) ++first_differs[static_cast<std::size_t>(first_differing_level(a, b))];
  }
  std::uint32_t cells = 1;
  for (std::size_t h = 0; h <= kMaxDepth; ++h) sorted.occupied[h] = cells += first_differs[h];
  return sorted;
}

Result<int> choose_depth(const std::array<std::uint32_t, kMaxDepth + 1>& occupied, std::uint64_t n,
                         const DepthRule& rule) {
  if (rule.kind == DepthRule::Kind::fixed) {
    if (rule.depth < 0 || rule.depth > kMaxDepth) {
      return fail("depth " + std::to_string(rule.depth) + " is not between 0 and " +
                  std::to_string(kMaxDepth));
    }
    return rule.depth;
  }
  if (!(rule.delta >= 0.0)) return fail("delta must be a number of at least 0");
  // ERRATA 4: the criterion alone never ends where points coincide, so it also stops at the level
  // that tells all distinct points apart. A level like the one above it is no reason to stop.
  const std::uint32_t distinct = occupied[kMaxDepth];
  const double wanted = (1.0 - rule.delta) * static_cast<double>(n);
  int depth = 0;
  while (depth < kMaxDepth) {
    const std::uint32_t cells = occupied[static_cast<std::size_t>(depth)];
    if (cells >= distinct || static_cast<double>(cells) >= wanted) break;
    ++depth;
  }
  return depth;
}

Svo build_svo(const SortedPoints& sorted, int depth) {
  Svo svo;
  svo.cube = sorted.cube;
  svo.depth = depth;
  std::vector<std::uint64_t> keys;
  keys.reserve(sorted.occupied[static_cast<std::size_t>(depth)]);
  const int shift = 3 * (kMaxDepth - depth);
  for (const KeyIndex& point : sorted.points) {
    const std::uint64_t key = point.key >> shift;
    if (keys.empty() || keys.back() != key) keys.push_back(key);
  }
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
