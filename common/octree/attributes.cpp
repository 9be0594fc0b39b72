#include <bit>
#include <cmath>

#include "common/octree/svo.h"

namespace pointreel {
namespace {

constexpr double kUnit = 32767.0;

glm::i64vec3 fixed_point(const glm::vec3& normal) {
  return {std::llround(normal.x * kUnit), std::llround(normal.y * kUnit),
          std::llround(normal.z * kUnit)};
}

/// The unit vector along an integer sum, or zero where opposed normals cancel.
glm::i16vec3 direction(const glm::i64vec3& sum) {
  const glm::dvec3 v(sum);
  const double length = glm::length(v);
  if (!(length > 0.0)) return glm::i16vec3(0);
  return glm::i16vec3(glm::round(v * (kUnit / length)));
}

glm::u16vec3 mean(const glm::u64vec3& sum, std::uint64_t count) {
  return glm::u16vec3((sum + count / 2) / count);
}

/// Fills the inner nodes, whose leaves are set, from the last to the root: children come behind
/// their parent, so each is complete when its parent needs it.
template <class Value, class Sum, class Average>
void fill_inner(const Svo& svo, const std::vector<std::uint32_t>& leaves_below,
                std::vector<Value>& values, Average average) {
  std::vector<Sum> sums(svo.internal_count());
  for (std::size_t i = svo.internal_count(); i-- > 0;) {
    Sum sum(0);
    const std::size_t first = svo.first_child[i];
    const std::size_t last = first + static_cast<std::size_t>(std::popcount(svo.masks[i]));
    for (std::size_t child = first; child < last; ++child) {
      sum += child < svo.internal_count() ? sums[child] : Sum(values[child]);
    }
    sums[i] = sum;
    values[i] = average(sum, leaves_below[i]);
  }
}

std::vector<std::uint32_t> count_leaves_below(const Svo& svo) {
  std::vector<std::uint32_t> count(svo.node_count(), 1);
  for (std::size_t i = svo.internal_count(); i-- > 0;) {
    std::uint32_t sum = 0;
    const int children = std::popcount(svo.masks[i]);
    for (int c = 0; c < children; ++c) sum += count[svo.first_child[i] + static_cast<unsigned>(c)];
    count[i] = sum;
  }
  return count;
}

void fill_inner(const Svo& svo, NodeAttributes& attributes) {
  if (!attributes.colors.empty()) {
    fill_inner<glm::u16vec3, glm::u64vec3>(svo, count_leaves_below(svo), attributes.colors, mean);
  }
  if (!attributes.normals.empty()) {
    fill_inner<glm::i16vec3, glm::i64vec3>(
        svo, std::vector<std::uint32_t>(svo.internal_count()), attributes.normals,
        [](const glm::i64vec3& sum, std::uint32_t) { return direction(sum); });
  }
}

}  // namespace

NodeAttributes mean_attributes(const Svo& svo, const PointCloud& cloud,
                               const SortedPoints& sorted) {
  NodeAttributes attributes;
  if (cloud.has_colors()) attributes.colors.resize(svo.node_count());
  if (cloud.has_normals()) attributes.normals.resize(svo.node_count());
  if (!cloud.has_colors() && !cloud.has_normals()) return attributes;

  const int shift = 3 * (kMaxDepth - svo.depth);
  std::size_t leaf = svo.internal_count();
  for (std::size_t i = 0; i < sorted.points.size(); ++leaf) {
    const std::uint64_t key = sorted.points[i].key >> shift;
    glm::u64vec3 color(0);
    glm::i64vec3 normal(0);
    std::uint64_t count = 0;
    for (; i < sorted.points.size() && sorted.points[i].key >> shift == key; ++i, ++count) {
      const std::uint32_t point = sorted.points[i].index;
      if (cloud.has_colors()) color += glm::u64vec3(cloud.colors[point]);
      if (cloud.has_normals()) normal += fixed_point(cloud.normals[point]);
    }
    if (cloud.has_colors()) attributes.colors[leaf] = mean(color, count);
    if (cloud.has_normals()) attributes.normals[leaf] = direction(normal);
  }
  fill_inner(svo, attributes);
  return attributes;
}

NodeAttributes mean_attributes(const Svo& svo, const PointCloud& leaves) {
  NodeAttributes attributes;
  if (leaves.has_colors()) {
    attributes.colors.resize(svo.internal_count());
    attributes.colors.insert(attributes.colors.end(), leaves.colors.begin(), leaves.colors.end());
  }
  if (leaves.has_normals()) {
    attributes.normals.resize(svo.internal_count());
    attributes.normals.reserve(svo.node_count());
    for (const glm::vec3& n : leaves.normals) {
      attributes.normals.push_back(direction(fixed_point(n)));
    }
  }
  fill_inner(svo, attributes);
  return attributes;
}

}  // namespace pointreel
