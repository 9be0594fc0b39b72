#include "client/strips/strips.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <span>

#include "client/strips/decimation.h"
#include "client/strips/each_triangle.h"
#include "common/base/for_each.h"

namespace pointreel {
namespace {

/// What a node needs to know of its children, besides what it keeps.
struct NodeSums {
  glm::vec3 min{std::numeric_limits<float>::max()}, max{std::numeric_limits<float>::lowest()};
  glm::dvec3 positions{0.0};
};

/// Patches that are made into strips by one call of the executor.
constexpr std::size_t kBlock = 64;

/// Fills in the sphere, the cone and the representative surfel of a patch.
void describe_patch(const StripSurfels& surfels, const PatchNode& patch,
                    std::span<const std::uint32_t> indices, StripNode& node, NodeSums& sums) {
  for (std::uint32_t i = patch.begin; i < patch.end; ++i)
    sums.positions += glm::dvec3(surfels.positions[i]);
  for (const std::uint32_t i : indices) {
    if (i == kEndOfStrip) continue;
    sums.min = glm::min(sums.min, surfels.positions[i]);
    sums.max = glm::max(sums.max, surfels.positions[i]);
  }
  glm::vec3 sum(0.0f);
  const auto normal_of = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    const glm::vec3& p = surfels.positions[a];
    return glm::cross(surfels.positions[b] - p, surfels.positions[c] - p);
  };
  each_triangle(indices, [&](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    sum += normal_of(a, b, c);
  });
  const float length = glm::length(sum);
  if (!(length > 0.0f)) return;
  node.axis = sum / length;
  float least = 1.0f;
  each_triangle(indices, [&](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    const glm::vec3 normal = normal_of(a, b, c);
    const float size = glm::length(normal);
    if (size > 0.0f) least = std::min(least, glm::dot(normal, node.axis) / size);
  });
  // Less than it is by a few roundings, so that no normal is outside.
  node.cosine = std::max(least - 1e-5f, -1.0f);
}

/// The smallest cone around an axis that holds the cones of some nodes.
float cosine_around(const glm::vec3& axis, std::span<const StripNode> nodes) {
  float widest = 0.0f;
  for (const StripNode& node : nodes) {
    if (node.indices == 0) continue;
    if (node.cosine <= -1.0f) return -1.0f;
    widest = std::max(widest, std::acos(std::clamp(glm::dot(axis, node.axis), -1.0f, 1.0f)) +
                                  std::acos(node.cosine));
  }
  return widest < 3.14f ? std::cos(widest) - 1e-5f : -1.0f;
}

/// The same for a node that has children, from theirs.
void describe_inner(std::span<const StripNode> children, std::span<const NodeSums> children_sums,
                    StripNode& node, NodeSums& sums) {
  glm::vec3 axis(0.0f);
  for (std::size_t i = 0; i < children.size(); ++i) {
    sums.min = glm::min(sums.min, children_sums[i].min);
    sums.max = glm::max(sums.max, children_sums[i].max);
    sums.positions += children_sums[i].positions;
    axis += children[i].axis;
  }
  const float length = glm::length(axis);
  if (!(length > 1e-3f)) return;
  node.axis = axis / length;
  node.cosine = cosine_around(node.axis, children);
}

}  // namespace

SurfelStrips make_strips(const StripSurfels& surfels, const NodeAttributes& attributes,
                         const StripRules& rules, const Executor& executor) {
  SurfelStrips strips;
  const StrippingTree tree = make_stripping_tree(surfels, rules.patch, executor);
  const Patches patches(surfels, tree, rules.inflation, executor);

  struct Block {
    std::vector<std::uint32_t> indices;
    std::vector<std::uint32_t> ends;       ///< of each patch
    std::vector<std::uint32_t> triangles;  ///< the number of each patch
  };
  std::vector<Block> blocks((patches.size() + kBlock - 1) / kBlock);
  for_each(executor, static_cast<int>(blocks.size()), [&](int number) {
    const std::size_t begin = static_cast<std::size_t>(number) * kBlock;
    Block& block = blocks[static_cast<std::size_t>(number)];
    std::vector<std::array<std::uint32_t, 3>> triangles;
    Decimation decimation(surfels, tree, patches);
    StripOrder order;
    for (std::size_t i = begin; i < std::min(begin + kBlock, patches.size()); ++i) {
      triangles.clear();
      decimation.run(static_cast<std::uint32_t>(i), triangles);
      order.run(triangles, block.indices);
      block.ends.push_back(static_cast<std::uint32_t>(block.indices.size()));
      block.triangles.push_back(static_cast<std::uint32_t>(triangles.size()));
    }
  });

  // Patches follow each other by their surfels, as the tree is walked in depth, so that what lies
  // below a node is always one range.
  std::vector<std::uint32_t> firsts;
  std::uint32_t total = 0;
  for (const Block& block : blocks) {
    firsts.push_back(total);
    total += static_cast<std::uint32_t>(block.indices.size());
  }
  strips.indices.resize(total);
  strips.nodes.resize(tree.nodes.size());
  std::vector<NodeSums> sums(tree.nodes.size());
  for_each(executor, static_cast<int>(blocks.size()), [&](int number) {
    const auto at = static_cast<std::size_t>(number);
    const Block& block = blocks[at];
    std::copy(block.indices.begin(), block.indices.end(),
              strips.indices.begin() + static_cast<std::ptrdiff_t>(firsts[at]));
    for (std::size_t i = 0; i < block.ends.size(); ++i) {
      const std::uint32_t begin = i == 0 ? 0 : block.ends[i - 1];
      const std::uint32_t number_of_node = tree.patches[at * kBlock + i];
      StripNode& node = strips.nodes[number_of_node];
      node.first_index = firsts[at] + begin;
      node.indices = block.ends[i] - begin;
      node.triangles = block.triangles[i];
      describe_patch(surfels, tree.nodes[number_of_node],
                     std::span(block.indices).subspan(begin, node.indices), node,
                     sums[number_of_node]);
    }
  });

  for (std::size_t i = tree.nodes.size(); i-- > 0;) {
    const PatchNode& from = tree.nodes[i];
    StripNode& node = strips.nodes[i];
    node.first_child = from.first_child;
    node.children = from.children;
    if (from.children > 0) {
      const auto children =
          std::span<const StripNode>(strips.nodes).subspan(from.first_child, from.children);
      describe_inner(children,
                     std::span<const NodeSums>(sums).subspan(from.first_child, from.children), node,
                     sums[i]);
      node.first_index = children.front().first_index;
      node.indices = children.back().first_index + children.back().indices - node.first_index;
      for (const StripNode& child : children) node.triangles += child.triangles;
    }
    node.position = glm::vec3(sums[i].positions / static_cast<double>(from.end - from.begin));
    if (node.indices > 0) {
      node.center = 0.5f * (sums[i].min + sums[i].max);
      node.radius = 0.5f * glm::length(sums[i].max - sums[i].min) * 1.00001f;
    } else {
      node.center = node.position;
    }
    if (!attributes.normals.empty()) node.normal = attributes.normals[from.svo_node];
    if (!attributes.colors.empty()) node.color = attributes.colors[from.svo_node];
  }
  return strips;
}

}  // namespace pointreel
