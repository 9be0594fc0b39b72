#include "client/strips/stripping_tree.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "common/base/for_each.h"

namespace pointreel {
namespace {

/// Nodes of a level that are tested by one call of the executor.
constexpr std::size_t kNodesPerBlock = 256;

/// The first surfel below each node of the octree.
std::vector<std::uint32_t> first_surfels(const Svo& svo) {
  std::vector<std::uint32_t> first(svo.node_count());
  const std::uint32_t internal = svo.internal_count();
  for (std::uint32_t leaf = 0; leaf < svo.leaf_count(); ++leaf) first[internal + leaf] = leaf;
  for (std::uint32_t node = internal; node-- > 0;) first[node] = first[svo.first_child[node]];
  return first;
}

/// The direction in which a set of positions is thinnest: the smallest of the principal axes.
/// Whatever is perpendicular to the two largest differences of a few positions does for this.
glm::vec3 thinnest(const StripSurfels& surfels, std::uint32_t begin, std::uint32_t end,
                   const glm::vec3& center) {
  glm::vec3 longest(0.0f), widest(0.0f);
  for (std::uint32_t i = begin; i < end; ++i) {
    const glm::vec3 d = surfels.positions[i] - center;
    if (glm::dot(d, d) > glm::dot(longest, longest)) longest = d;
  }
  for (std::uint32_t i = begin; i < end; ++i) {
    const glm::vec3 across = glm::cross(longest, surfels.positions[i] - center);
    if (glm::dot(across, across) > glm::dot(widest, widest)) widest = across;
  }
  const float length = glm::length(widest);
  return length > 0.0f ? widest / length : glm::vec3(0.0f, 0.0f, 1.0f);
}

bool is_height_map(const StripSurfels& surfels, const PatchNode& node, const PatchRule& rule) {
  const PatchPlane plane = patch_plane(surfels, node.begin, node.end);
  float highest = 0.0f, farthest = 0.0f, radii = 0.0f;
  for (std::uint32_t i = node.begin; i < node.end; ++i) {
    const glm::vec3& normal = surfels.normals[i];
    float cosine = glm::dot(normal, plane.normal);
    if (surfels.lines) cosine = std::abs(cosine);
    if (!(cosine > rule.least_cosine) && normal != glm::vec3(0.0f)) return false;
    const glm::vec3 d = surfels.positions[i] - plane.center;
    highest = std::max(highest, std::abs(glm::dot(d, plane.normal)));
    farthest = std::max(farthest, glm::dot(d, d));
    radii += surfels.radii[i];
  }
  const float noise = rule.noise * radii / static_cast<float>(node.end - node.begin);
  return highest <= std::max(rule.most_height * std::sqrt(farthest), noise);
}

bool is_patch(const StripSurfels& surfels, const PatchNode& node, const PatchRule& rule) {
  if (node.level == surfels.svo.depth) return true;
  return node.end - node.begin <= rule.most && is_height_map(surfels, node, rule);
}

}  // namespace

std::pair<std::uint32_t, std::uint32_t> StrippingTree::surfels_below(const Svo& svo,
                                                                     std::uint32_t node,
                                                                     int level) const {
  const bool last = node + 1 == svo.level_begin[static_cast<std::size_t>(level) + 1];
  return {first_surfel[node], last ? svo.leaf_count() : first_surfel[node + 1]};
}

PatchPlane patch_plane(const StripSurfels& surfels, std::uint32_t begin, std::uint32_t end) {
  glm::vec3 sum(0.0f), normals(0.0f);
  for (std::uint32_t i = begin; i < end; ++i) {
    sum += surfels.positions[i] - surfels.positions[begin];
    const glm::vec3& normal = surfels.normals[i];
    normals += surfels.lines && glm::dot(normal, normals) < 0.0f ? -normal : normal;
  }
  PatchPlane plane;
  plane.center = surfels.positions[begin] + sum / static_cast<float>(end - begin);
  const float length = glm::length(normals);
  plane.normal = length > 1e-3f ? normals / length : thinnest(surfels, begin, end, plane.center);
  return plane;
}

StrippingTree make_stripping_tree(const StripSurfels& surfels, const PatchRule& rule,
                                  const Executor& executor) {
  const Svo& svo = surfels.svo;
  StrippingTree tree;
  if (svo.leaf_count() == 0) return tree;
  tree.first_surfel = first_surfels(svo);
  PatchNode root;
  root.end = svo.leaf_count();
  root.around.fill(kNoNode);
  root.around[13] = 0;
  tree.nodes.push_back(root);
  std::vector<std::uint8_t> ends;  // for each node of a level, whether it is a patch
  for (std::size_t begin = 0, end = 1; begin < end; begin = end, end = tree.nodes.size()) {
    ends.resize(end - begin);
    for_each(executor, static_cast<int>((end - begin + kNodesPerBlock - 1) / kNodesPerBlock),
             [&](int block) {
               const std::size_t from = begin + static_cast<std::size_t>(block) * kNodesPerBlock;
               for (std::size_t i = from; i < std::min(from + kNodesPerBlock, end); ++i)
                 ends[i - begin] = is_patch(surfels, tree.nodes[i], rule);
             });
    for (std::size_t i = begin; i < end; ++i) {
      if (ends[i - begin] != 0) {
        tree.patches.push_back(static_cast<std::uint32_t>(i));
        continue;
      }
      const std::uint32_t parent = tree.nodes[i].svo_node;
      const auto children = static_cast<std::uint8_t>(std::popcount(svo.masks[parent]));
      std::array<NodeBlock, 8> blocks;
      child_blocks(svo, tree.nodes[i].around, blocks.data());
      tree.nodes[i].first_child = static_cast<std::uint32_t>(tree.nodes.size());
      tree.nodes[i].children = children;
      const auto level = static_cast<std::uint8_t>(tree.nodes[i].level + 1);
      for (std::uint8_t child = 0; child < children; ++child) {
        const std::uint32_t node = svo.first_child[parent] + child;
        const auto [from, to] = tree.surfels_below(svo, node, level);
        tree.nodes.push_back(
            {node, static_cast<std::uint32_t>(i), from, to, 0, 0, level, blocks[child]});
      }
    }
  }
  std::sort(tree.patches.begin(), tree.patches.end(), [&](std::uint32_t a, std::uint32_t b) {
    return tree.nodes[a].begin < tree.nodes[b].begin;
  });
  tree.patch_of.resize(svo.leaf_count());
  for (std::size_t i = 0; i < tree.patches.size(); ++i) {
    const PatchNode& patch = tree.nodes[tree.patches[i]];
    std::fill(tree.patch_of.begin() + patch.begin, tree.patch_of.begin() + patch.end,
              static_cast<std::uint32_t>(i));
  }
  return tree;
}

}  // namespace pointreel
