#include "client/strips/strips.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <span>
#include <utility>

#include "client/strips/decimation.h"
#include "client/strips/each_triangle.h"
#include "client/strips/kept_patches.h"
#include "client/strips/strip_record.h"
#include "common/base/for_each.h"

namespace pointreel {
namespace {

/// Patches that are made into strips by one call of the executor.
constexpr std::size_t kPatchesPerBlock = 64;

/// Fills in the sphere, the cone and the representative surfel of a patch.
void describe_patch(const StripSurfels& surfels, const PatchNode& patch,
                    std::span<const std::uint32_t> indices, StripNode& node, StripSums& sums) {
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
void describe_inner(std::span<const StripNode> children, std::span<const StripSums> children_sums,
                    StripNode& node, StripSums& sums) {
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

void set_attributes(const StrippingTree& tree, const NodeAttributes& attributes,
                    std::span<StripNode> nodes) {
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const std::uint32_t from = tree.nodes[i].svo_node;
    nodes[i].normal = attributes.normals.empty() ? glm::i16vec3(0) : attributes.normals[from];
    nodes[i].color = attributes.colors.empty() ? glm::u16vec3(0) : attributes.colors[from];
  }
}

/// The strips of patches that follow each other.
struct Block {
  std::vector<std::uint32_t> indices;
  std::vector<std::uint32_t> ends;       ///< of each patch
  std::vector<std::uint32_t> triangles;  ///< the number of each patch
  std::vector<std::uint8_t> same;        ///< whether the strips of each patch are those of a record
};

/// Makes the strips of one set of surfels.
class StripMaker {
 public:
  /// Everything given outlives this. `before`: if there are `changes`, the record that they refer
  /// to, by the same rules.
  StripMaker(const StripSurfels& surfels, const StripRules& rules, const Executor& executor,
             const StripRecord* before = nullptr, std::optional<SurfelChanges> changes = {})
      : surfels_(surfels), executor_(executor), before_(before) {
    tree = make_stripping_tree(surfels, rules.patch, executor);
    if (changes)
      kept_.emplace(*before, std::move(*changes), surfels, tree, rules.inflation, executor);
    patches = Patches(surfels, tree, rules.inflation, executor, kept());
    blocks_.resize((patches.size() + kPatchesPerBlock - 1) / kPatchesPerBlock);
    for_each(executor, static_cast<int>(blocks_.size()),
             [&](int number) { make_block(static_cast<std::size_t>(number)); });
    place_blocks();
  }

  /// Describes all nodes from the last to the first, and so children before their parents.
  void describe_nodes(const NodeAttributes& attributes);
  /// The number of patches whose strips were made, not taken from a record.
  std::uint32_t made() const;

  StrippingTree tree;
  Patches patches;
  SurfelStrips strips;
  std::vector<StripSums> sums;

 private:
  const KeptPatches* kept() const { return kept_ ? &*kept_ : nullptr; }
  void make_block(std::size_t number);
  void place_blocks();

  const StripSurfels& surfels_;
  const Executor& executor_;
  const StripRecord* before_;
  std::optional<KeptPatches> kept_;
  std::vector<Block> blocks_;
};

std::uint32_t StripMaker::made() const {
  std::size_t made = 0;
  for (const Block& block : blocks_)
    made += static_cast<std::size_t>(std::count(block.same.begin(), block.same.end(), 0));
  return static_cast<std::uint32_t>(made);
}

void StripMaker::make_block(std::size_t number) {
  const std::size_t begin = number * kPatchesPerBlock;
  Block& block = blocks_[number];
  std::vector<std::array<std::uint32_t, 3>> triangles;
  Decimation decimation(surfels_, tree, patches);
  StripOrder order;
  for (std::size_t i = begin; i < std::min(begin + kPatchesPerBlock, patches.size()); ++i) {
    const bool same = kept_ && kept_->same_strips(i, patches);
    if (same) {
      const std::uint32_t node = before_->tree.patches[kept_->patch_before(i)];
      const StripNode& old = before_->strips.nodes[node];
      for (const std::uint32_t surfel :
           std::span(before_->strips.indices).subspan(old.first_index, old.indices))
        block.indices.push_back(surfel == kEndOfStrip ? surfel : kept_->surfel_now(surfel));
      block.triangles.push_back(old.triangles);
    } else {
      triangles.clear();
      decimation.run(static_cast<std::uint32_t>(i), triangles);
      order.run(triangles, block.indices);
      block.triangles.push_back(static_cast<std::uint32_t>(triangles.size()));
    }
    block.same.push_back(same ? 1 : 0);
    block.ends.push_back(static_cast<std::uint32_t>(block.indices.size()));
  }
}

void StripMaker::place_blocks() {
  // Patches follow each other by their surfels, as the tree is walked in depth, so that what lies
  // below a node is always one range.
  std::vector<std::uint32_t> firsts;
  std::uint32_t total = 0;
  for (const Block& block : blocks_) {
    firsts.push_back(total);
    total += static_cast<std::uint32_t>(block.indices.size());
  }
  strips.indices.resize(total);
  strips.nodes.resize(tree.nodes.size());
  sums.resize(tree.nodes.size());
  for_each(executor_, static_cast<int>(blocks_.size()), [&](int number) {
    const auto at = static_cast<std::size_t>(number);
    const Block& block = blocks_[at];
    std::copy(block.indices.begin(), block.indices.end(),
              strips.indices.begin() + static_cast<std::ptrdiff_t>(firsts[at]));
    for (std::size_t i = 0; i < block.ends.size(); ++i) {
      const std::size_t patch = at * kPatchesPerBlock + i;
      const std::uint32_t begin = i == 0 ? 0 : block.ends[i - 1];
      const std::uint32_t number_of_node = tree.patches[patch];
      StripNode& node = strips.nodes[number_of_node];
      if (block.same[i] != 0) {
        const std::uint32_t old = before_->tree.patches[kept_->patch_before(patch)];
        node.axis = before_->strips.nodes[old].axis;
        node.cosine = before_->strips.nodes[old].cosine;
        sums[number_of_node] = before_->sums[old];
      } else {
        describe_patch(surfels_, tree.nodes[number_of_node],
                       std::span(block.indices).subspan(begin, block.ends[i] - begin), node,
                       sums[number_of_node]);
      }
      node.first_index = firsts[at] + begin;
      node.indices = block.ends[i] - begin;
      node.triangles = block.triangles[i];
    }
  });
}

void StripMaker::describe_nodes(const NodeAttributes& attributes) {
  for (std::size_t i = tree.nodes.size(); i-- > 0;) {
    const PatchNode& from = tree.nodes[i];
    StripNode& node = strips.nodes[i];
    node.first_child = from.first_child;
    node.children = from.children;
    if (from.children > 0) {
      const auto children =
          std::span<const StripNode>(strips.nodes).subspan(from.first_child, from.children);
      describe_inner(children,
                     std::span<const StripSums>(sums).subspan(from.first_child, from.children),
                     node, sums[i]);
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
  }
  set_attributes(tree, attributes, strips.nodes);
}

bool can_update(const StripRecord& record, const StripSurfels& surfels, const StripRules& rules) {
  return record.svo.cube == surfels.svo.cube && record.svo.depth == surfels.svo.depth &&
         record.lines == surfels.lines && record.rules == rules && record.svo.leaf_count() > 0 &&
         surfels.svo.leaf_count() > 0;
}

}  // namespace

SurfelStrips make_strips(const StripSurfels& surfels, const NodeAttributes& attributes,
                         const StripRules& rules, const Executor& executor) {
  StripMaker maker(surfels, rules, executor);
  maker.describe_nodes(attributes);
  return std::move(maker.strips);
}

RecordedStrips update_strips(const StripSurfels& surfels, const NodeAttributes& attributes,
                             const std::shared_ptr<const StripRecord>& before,
                             const StripRules& rules, const Executor& executor) {
  std::optional<SurfelChanges> changes;
  if (before && can_update(*before, surfels, rules)) {
    changes.emplace(before->surfels(), surfels, executor);
    if (changes->none()) {
      RecordedStrips same{before->strips, before};
      set_attributes(before->tree, attributes, same.strips.nodes);
      return same;
    }
  }
  StripMaker maker(surfels, rules, executor, before.get(), std::move(changes));
  maker.describe_nodes(attributes);
  auto record = std::make_shared<StripRecord>(StripRecord{
      .rules = rules,
      .svo = surfels.svo,
      .positions = {surfels.positions.begin(), surfels.positions.end()},
      .normals = {surfels.normals.begin(), surfels.normals.end()},
      .radii = {surfels.radii.begin(), surfels.radii.end()},
      .lines = surfels.lines,
      .tree = std::move(maker.tree),
      .patches = std::move(maker.patches),
      .strips = maker.strips,
      .sums = std::move(maker.sums),
  });
  return {std::move(maker.strips), std::move(record), maker.made()};
}

}  // namespace pointreel
