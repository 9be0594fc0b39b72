#include <bit>
#include <cmath>
#include <cstddef>
#include <memory>
#include <utility>

#include "codec/core/build.h"
#include "codec/core/normal_lines.h"
#include "common/base/blocks.h"
#include "pointreel/octree.h"

namespace pointreel {
namespace {

constexpr double kUnit = 32767.0;

/// Rounds half away from zero, as llround does, but inline.
std::int64_t round_to_int(double v) { return static_cast<std::int64_t>(v + std::copysign(0.5, v)); }

glm::i64vec3 fixed_point(const glm::vec3& normal) {
  return {round_to_int(normal.x * kUnit), round_to_int(normal.y * kUnit),
          round_to_int(normal.z * kUnit)};
}

/// The unit vector along an integer sum, or zero where opposed normals cancel.
glm::i16vec3 direction(const glm::i64vec3& sum) {
  const glm::dvec3 v(sum);
  const double length = glm::length(v);
  if (!(length > 0.0)) return glm::i16vec3(0);
  const glm::dvec3 scaled = v * (kUnit / length);
  return glm::i16vec3(round_to_int(scaled.x), round_to_int(scaled.y), round_to_int(scaled.z));
}

/// `direction` of fixed_point(normal), where a leaf has a single normal: in doubles throughout,
/// which is faster.
glm::i16vec3 single_direction(const glm::vec3& normal) {
  const auto rounded = [](double v) { return std::trunc(v + std::copysign(0.5, v)); };
  const glm::dvec3 v(rounded(normal.x * kUnit), rounded(normal.y * kUnit),
                     rounded(normal.z * kUnit));
  const double length = std::sqrt(v.x * v.x + v.y * v.y + v.z * v.z);
  if (!(length > 0.0)) return glm::i16vec3(0);
  const double scale = kUnit / length;
  const auto scaled = [&](double component) {
    return static_cast<std::int16_t>(static_cast<std::int32_t>(rounded(component * scale)));
  };
  return {scaled(v.x), scaled(v.y), scaled(v.z)};
}

/// `direction` in the form of `mean`: the number of vectors does not matter.
glm::i16vec3 mean_direction(const glm::i64vec3& sum, std::uint32_t) { return direction(sum); }

/// Sums over normals n whose signs are unknown: n n^T, and n for the majority of the signs. Exact.
struct LineSum {
  glm::i64vec3 diagonal, mixed;  ///< xx, yy, zz; yz, zx, xy
  glm::i64vec3 normals;

  LineSum() {}  // sets nothing, as those of glm do
  explicit LineSum(const glm::i64vec3& n)
      : diagonal(n * n), mixed(n.y * n.z, n.z * n.x, n.x * n.y), normals(n) {}
  explicit LineSum(const glm::i16vec3& n) : LineSum(glm::i64vec3(n)) {}
  LineSum& operator+=(const LineSum& other) {
    diagonal += other.diagonal;
    mixed += other.mixed;
    normals += other.normals;
    return *this;
  }
};

/// The unit vector along the axis to which the lines are closest, or zero without lines. Squaring a
/// matrix, which is scaled in between, makes its largest eigenvalue dominate the others.
glm::i16vec3 mean_line(const LineSum& sum, std::uint32_t /*count*/) {
  const glm::dvec3 d(sum.diagonal), m(sum.mixed);
  glm::dmat3 axes(d.x, m.z, m.y, m.z, d.y, m.x, m.y, m.x, d.z);
  constexpr int kSquarings = 6;
  for (int i = 0; i < kSquarings; ++i) {
    const double trace = axes[0][0] + axes[1][1] + axes[2][2];
    if (!(trace > 0.0)) return glm::i16vec3(0);
    axes *= 1.0 / trace;
    axes = axes * axes;
  }
  int longest = 0;
  for (int i = 1; i < 3; ++i) {
    if (axes[i][i] > axes[longest][longest]) longest = i;
  }
  glm::dvec3 axis = axes[longest];
  if (glm::dot(axis, glm::dvec3(sum.normals)) < 0.0) axis = -axis;
  const double length = glm::length(axis);
  if (!(length > 0.0)) return glm::i16vec3(0);
  axis *= kUnit / length;
  return glm::i16vec3(round_to_int(axis.x), round_to_int(axis.y), round_to_int(axis.z));
}

/// The sum divided by the count, rounded. Computed in double, which is exact because the sum is
/// below 2^48, and much faster than dividing 64-bit integers.
glm::u16vec3 mean(const glm::i64vec3& sum, std::uint32_t count) {
  if (count == 1) return glm::u16vec3(sum);
  return glm::u16vec3(glm::dvec3(sum + std::int64_t{count / 2}) / static_cast<double>(count));
}

/// Fills the leaves of a tree from the points in each. `get` returns a point's value as a Sum, and
/// `single` what stands for a leaf that has no other point.
template <class Sum, class Value, class Get, class Single, class Average>
void fill_leaves(const Svo& svo, const SortedPoints& sorted, Value* leaves, Get get, Single single,
                 Average average, const Executor& executor) {
  const int shift = 3 * (sorted.levels - svo.depth);
  const KeyIndex* const points = sorted.points.data();
  const std::size_t count = sorted.points.size();
  const Blocks blocks(executor, count, kLeastPerBlock);
  // A block fills the leaves whose first points it holds, to their last points.
  const auto begins_leaf = [&](std::size_t i) {
    return i == 0 || points[i].key >> shift != points[i - 1].key >> shift;
  };
  std::vector<std::size_t> first_leaf(blocks.count() + 1);
  if (blocks.count() > 1) {
    for_each_block(executor, blocks, [&](std::size_t block, std::size_t begin, std::size_t end) {
      std::size_t began = 0;
      for (std::size_t i = begin; i < end; ++i) began += static_cast<std::size_t>(begins_leaf(i));
      first_leaf[block + 1] = began;
    });
    for (std::size_t i = 0; i < blocks.count(); ++i) first_leaf[i + 1] += first_leaf[i];
  }
  for_each_block(executor, blocks,
                 [&](std::size_t block, std::size_t begin, std::size_t block_end) {
                   while (begin < block_end && !begins_leaf(begin)) ++begin;
                   Value* leaf = leaves + first_leaf[block];
                   const KeyIndex* point = points + begin;
                   const KeyIndex *const end = points + count, *const last = points + block_end;
                   for (; point < last; ++leaf) {
                     const std::uint64_t key = point->key >> shift;
                     if (point + 1 == end || point[1].key >> shift != key) {
                       *leaf = single((point++)->index);
                       continue;
                     }
                     Sum sum = get(point->index);
                     std::uint32_t in_leaf = 1;
                     for (++point; point < end && point->key >> shift == key; ++point, ++in_leaf) {
                       sum += get(point->index);
                     }
                     *leaf = average(sum, in_leaf);
                   }
                 });
}

void fill_leaf_colors(const Svo& svo, const PointCloud& cloud, const SortedPoints& sorted,
                      glm::u16vec3* leaf, const Executor& executor) {
  fill_leaves<glm::i64vec3>(
      svo, sorted, leaf, [&](std::uint32_t point) { return glm::i64vec3(cloud.colors[point]); },
      [&](std::uint32_t point) { return cloud.colors[point]; }, mean, executor);
}

void fill_leaf_normals(const Svo& svo, const PointCloud& cloud, const SortedPoints& sorted,
                       glm::i16vec3* leaf, const Executor& executor) {
  fill_leaves<glm::i64vec3>(
      svo, sorted, leaf, [&](std::uint32_t point) { return fixed_point(cloud.normals[point]); },
      [&](std::uint32_t point) { return single_direction(cloud.normals[point]); }, mean_direction,
      executor);
}

/// Fills the inner nodes of a tree whose leaves are set, level by level upwards, from the sums over
/// the leaves below each node. `average` turns a sum and the number of leaves in it into a value.
template <class Sum, class Value, class Average>
void fill_inner(const Svo& svo, std::vector<Value>& values, Average average,
                const Executor& executor) {
  struct Below {
    Sum sum;
    std::uint32_t leaves;
  };
  // Arrays that are not set: every level is, but for the leaves, whose sums are their values.
  std::unique_ptr<Below[]> level_below, children;
  for (int level = svo.depth - 1; level >= 0; --level) {
    const std::size_t first = svo.level_begin[static_cast<std::size_t>(level)];
    const std::size_t first_child = svo.level_begin[static_cast<std::size_t>(level) + 1];
    const std::size_t count = first_child - first;
    if (level == svo.depth - 1) {
      level_below = std::make_unique_for_overwrite<Below[]>(count);
      children = std::make_unique_for_overwrite<Below[]>(count);
    }
    const bool above_leaves = level == svo.depth - 1;
    const auto below_child = [&](std::size_t child) {
      return above_leaves ? Below{Sum(values[child]), 1} : children[child - first_child];
    };
    const Blocks blocks(executor, count, kLeastPerBlock / 4);
    for_each_block(executor, blocks, [&](std::size_t, std::size_t begin, std::size_t end) {
      for (std::size_t node = first + begin; node < first + end; ++node) {
        const auto child = static_cast<std::size_t>(svo.first_child[node]);
        const int children_count = std::popcount(svo.masks[node]);
        Below below = below_child(child);
        if (children_count == 1) {
          values[node] = values[child];
        } else {
          for (int c = 1; c < children_count; ++c) {
            const Below other = below_child(child + static_cast<std::size_t>(c));
            below.sum += other.sum;
            below.leaves += other.leaves;
          }
          values[node] = average(below.sum, below.leaves);
        }
        level_below[node - first] = below;
      }
    });
    children.swap(level_below);
  }
}

}  // namespace

std::vector<glm::u16vec3> mean_colors(const Svo& svo, const PointCloud& cloud,
                                      const SortedPoints& sorted, const Executor& executor) {
  std::vector<glm::u16vec3> colors(svo.node_count());
  fill_leaf_colors(svo, cloud, sorted, colors.data() + svo.internal_count(), executor);
  fill_inner<glm::i64vec3>(svo, colors, mean, executor);
  return colors;
}

std::vector<glm::i16vec3> mean_normals(const Svo& svo, const PointCloud& cloud,
                                       const SortedPoints& sorted, const Executor& executor) {
  std::vector<glm::i16vec3> normals(svo.node_count());
  fill_leaf_normals(svo, cloud, sorted, normals.data() + svo.internal_count(), executor);
  fill_inner<glm::i64vec3>(svo, normals, mean_direction, executor);
  return normals;
}

NodeAttributes mean_attributes(const Svo& svo, const PointCloud& cloud, const SortedPoints& sorted,
                               const Executor& executor) {
  NodeAttributes attributes;
  if (cloud.has_colors()) attributes.colors = mean_colors(svo, cloud, sorted, executor);
  if (cloud.has_normals()) attributes.normals = mean_normals(svo, cloud, sorted, executor);
  return attributes;
}

std::vector<glm::u16vec3> mean_leaf_colors(const Svo& svo, const PointCloud& cloud,
                                           const SortedPoints& sorted, const Executor& executor) {
  std::vector<glm::u16vec3> colors(svo.leaf_count());
  fill_leaf_colors(svo, cloud, sorted, colors.data(), executor);
  return colors;
}

std::vector<glm::i16vec3> mean_leaf_normals(const Svo& svo, const PointCloud& cloud,
                                            const SortedPoints& sorted, const Executor& executor) {
  std::vector<glm::i16vec3> normals(svo.leaf_count());
  fill_leaf_normals(svo, cloud, sorted, normals.data(), executor);
  return normals;
}

NodeAttributes mean_attributes(const Svo& svo, const PointCloud& leaves, const Executor& executor) {
  NodeAttributes attributes;
  if (leaves.has_colors()) {
    attributes.colors.resize(svo.internal_count());
    attributes.colors.insert(attributes.colors.end(), leaves.colors.begin(), leaves.colors.end());
    fill_inner<glm::i64vec3>(svo, attributes.colors, mean, executor);
  }
  if (leaves.has_normals()) {
    attributes.normals.resize(svo.internal_count());
    attributes.normals.reserve(svo.node_count());
    for (const glm::vec3& n : leaves.normals) {
      attributes.normals.push_back(direction(fixed_point(n)));
    }
    fill_inner<glm::i64vec3>(svo, attributes.normals, mean_direction, executor);
  }
  return attributes;
}

std::vector<glm::i16vec3> mean_normal_lines(const Svo& svo, const PointCloud& cloud,
                                            const SortedPoints& sorted, const Executor& executor) {
  std::vector<glm::i16vec3> normals(svo.node_count());
  fill_leaves<LineSum>(
      svo, sorted, normals.data() + svo.internal_count(),
      [&](std::uint32_t point) { return LineSum(fixed_point(cloud.normals[point])); },
      [&](std::uint32_t point) { return mean_line(LineSum(fixed_point(cloud.normals[point])), 1); },
      mean_line, executor);
  fill_inner<LineSum>(svo, normals, mean_line, executor);
  return normals;
}

std::vector<glm::i16vec3> mean_normal_lines(const Svo& svo, const PointCloud& leaves,
                                            const Executor& executor) {
  std::vector<glm::i16vec3> normals(svo.node_count());
  for (std::size_t i = 0; i < leaves.size(); ++i)
    normals[svo.internal_count() + i] = direction(fixed_point(leaves.normals[i]));
  fill_inner<LineSum>(svo, normals, mean_line, executor);
  return normals;
}

}  // namespace pointreel
